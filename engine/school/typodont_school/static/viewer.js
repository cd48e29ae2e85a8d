// Shows a session's surface, which can be turned.
import * as THREE from './vendor/three.module.min.js';
import { GLTFLoader } from './vendor/loaders/GLTFLoader.js';
import { OrbitControls } from './vendor/controls/OrbitControls.js';

const canvas = document.getElementById('view');
const sorry = () => { canvas.hidden = true; document.getElementById('help').hidden = true; document.getElementById('no-view').hidden = false; };

function show() {
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(35, 1, 0.0005, 1);
  camera.up.set(0, 0, 1);  // the workbench's z
  scene.add(new THREE.HemisphereLight(0xffffff, 0x59656b, 1.6));
  const lamp = new THREE.DirectionalLight(0xffffff, 2.2);
  scene.add(lamp, lamp.target);
  const controls = new OrbitControls(camera, canvas);
  const draw = () => {
    const { clientWidth: width, clientHeight: height } = canvas;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    lamp.position.copy(camera.position);
    lamp.target.position.copy(controls.target);
    renderer.render(scene, camera);
  };
  controls.addEventListener('change', draw);
  new ResizeObserver(draw).observe(canvas);
  new GLTFLoader().load(canvas.dataset.surface, ({ scene: model }) => {
    model.traverse(part => {
      if (part.isMesh) {
        if (!part.geometry.attributes.normal) part.geometry.computeVertexNormals();
        const colored = !!part.geometry.attributes.color;
        part.material = new THREE.MeshStandardMaterial({ color: colored ? 0xffffff : 0xeee3cd, vertexColors: colored, roughness: 0.45 });
      }
    });
    scene.add(model);
    const ball = new THREE.Box3().setFromObject(model).getBoundingSphere(new THREE.Sphere());
    controls.target.copy(ball.center);
    camera.position.copy(ball.center).add(new THREE.Vector3(0.35, -1.1, 1.9).multiplyScalar(ball.radius * 1.2));
    controls.update();
    draw();
    canvas.dataset.shown = 'yes';
  }, undefined, sorry);
  canvas.addEventListener('keydown', event => {
    const turn = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    const zoom = { '+': 0.9, '-': 1 / 0.9 }[event.key];
    if (!turn && !zoom) return;
    event.preventDefault();
    const arm = camera.position.clone().sub(controls.target);
    const round = new THREE.Spherical().setFromVector3(new THREE.Vector3(arm.x, arm.z, -arm.y));
    if (turn) { round.theta += turn[0]; round.phi = Math.min(3.1, Math.max(0.05, round.phi + turn[1])); }
    if (zoom) round.radius *= zoom;
    const v = new THREE.Vector3().setFromSpherical(round);
    camera.position.copy(controls.target).add(new THREE.Vector3(v.x, -v.z, v.y));
    controls.update();
    draw();
  });
}

try { show(); } catch { sorry(); }
