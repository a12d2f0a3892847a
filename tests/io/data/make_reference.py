"""Write panda-pinocchio.json: link poses and mass matrices of the Panda in random configurations, by Pinocchio."""

import json
from pathlib import Path

import numpy as np
import pinocchio as pin

HERE = Path(__file__).parent


def main() -> None:
    model = pin.buildModelFromUrdf(str(HERE / "panda.urdf"))
    data, rng = model.createData(), np.random.default_rng(1)
    links = [frame.name for frame in model.frames if frame.type == pin.FrameType.BODY]
    poses = [_pose(model, data, links, rng.uniform(-3, 3, model.nq)) for _ in range(10)]
    told = {"pinocchio": pin.__version__, "joints": list(model.names)[1:], "links": links, "poses": poses}
    (HERE / "panda-pinocchio.json").write_text(json.dumps(told) + "\n")


def _pose(model, data, links, q) -> dict:
    pin.framesForwardKinematics(model, data, q)
    frames = [data.oMf[model.getFrameId(link, pin.FrameType.BODY)] for link in links]
    upper = np.triu(pin.crba(model, data, q))
    return {
        "q": q.tolist(),
        "r": [frame.translation.tolist() for frame in frames],
        "A": [frame.rotation.tolist() for frame in frames],
        "M": (upper + np.triu(upper, 1).T).tolist(),
    }


if __name__ == "__main__":
    main()
