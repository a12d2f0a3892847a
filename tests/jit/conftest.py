import pytest

from sarrus.elements import Element
from sarrus.model import Force, Joint


@pytest.fixture(scope="module")
def own_classes():
    """Classes made in these tests leave no trace in the registries."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Element, "registry", dict(Element.registry))
        patch.setattr(Joint, "kinds", dict(Joint.kinds))
        patch.setattr(Force, "kinds", dict(Force.kinds))
        yield
