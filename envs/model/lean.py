"""Takes out of a specification what is only drawn: the model then simulates faster."""

import mujoco

ARENA = 500_000  # bytes for contacts, of which an arm needs some 3,000; MuJoCo reserves 13 MB


def make_lean(spec: mujoco.MjSpec) -> None:
    """Removes geoms without mass and contact, empty bodies, lights, cameras and pictures, in place.

    Joints, sensors, actuators and keyframes stay what they are.
    """
    postures = [(key.name, list(key.qpos), list(key.act), list(key.ctrl)) for key in spec.keys]
    for key in spec.keys:  # MuJoCo checks their sizes at every deletion, and counts too few inputs
        spec.delete(key)
    for geom in [*spec.geoms]:
        weighs = geom.mass != 0 and _moves(geom.parent)
        if not (weighs or geom.contype or geom.conaffinity):
            spec.delete(geom)
    for body in reversed([*spec.bodies][1:]):  # a child comes after its parent
        if not (body.geoms or body.sites or body.joints or body.bodies or body.mass):
            spec.delete(body)
    for part in [*spec.lights, *spec.cameras]:
        spec.delete(part)
    for geom in spec.geoms:
        geom.material = ""
    used = {geom.meshname for geom in spec.geoms}
    unused = [mesh for mesh in spec.meshes if mesh.name not in used]
    for part in [*spec.materials, *spec.textures, *unused]:
        spec.delete(part)
    for name, qpos, act, ctrl in postures:
        spec.add_key(name=name, qpos=qpos, act=act, ctrl=ctrl)
    spec.memory = ARENA


def _moves(body: mujoco.MjsBody) -> bool:
    while body.name != "world":
        if body.joints:
            return True
        body = body.parent
    return False
