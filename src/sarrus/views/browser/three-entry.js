// What viewer.js takes from three.js. three.min.js is made of this, with three 0.187.0 and esbuild 0.28.2:
//   esbuild three-entry.js --bundle --minify --format=iife --global-name=THREE --target=es2020 \
//     --legal-comments=none --outfile=three.min.js
export {
  BufferAttribute, BufferGeometry, CanvasTexture, Color, ConeGeometry, CylinderGeometry, DirectionalLight,
  DoubleSide, FrontSide, GridHelper, Group, Mesh, MeshBasicMaterial, MeshStandardMaterial, NeutralToneMapping,
  OrthographicCamera, PCFShadowMap, PMREMGenerator, PerspectiveCamera, PlaneGeometry, Quaternion, REVISION,
  Raycaster, Scene, ShadowMaterial, Sprite, SpriteMaterial, Vector2, Vector3, WebGLRenderer, Box3,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
export { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";
export { Line2 } from "three/addons/lines/Line2.js";
export { LineGeometry } from "three/addons/lines/LineGeometry.js";
export { LineMaterial } from "three/addons/lines/LineMaterial.js";
