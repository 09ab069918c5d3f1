"""Removes from a specification what is only drawn: the model then simulates faster."""

import mujoco

ARENA = 200_000  # [bytes], memory for contacts: an arm needs 14,400, MuJoCo reserves 13 MB


def make_lean(spec: mujoco.MjSpec) -> None:
    """Removes geoms without mass and contact, empty bodies, lights, cameras and pictures, in place.

    Joints, sensors, actuators and keyframes stay unchanged.
    """
    postures = [(key.name, list(key.qpos), list(key.act), list(key.ctrl)) for key in spec.keys]
    for key in spec.keys:  # MuJoCo checks their sizes at every deletion, and counts too few inputs
        spec.delete(key)
    remove_drawings(spec)
    _write_inertias(spec)
    for geom in [*spec.geoms]:
        if not _is_solid(geom):
            spec.delete(geom)
    for body in reversed([*spec.bodies][1:]):  # a child comes after its parent
        if not (body.geoms or body.sites or body.joints or body.bodies or body.mass):
            spec.delete(body)
    for mesh in [*spec.meshes]:
        spec.delete(mesh)
    for name, qpos, act, ctrl in postures:
        spec.add_key(name=name, qpos=qpos, act=act, ctrl=ctrl)
    spec.memory = ARENA


def remove_drawings(spec: mujoco.MjSpec) -> None:
    """Removes what is only drawn, in place; keyframes must be removed before."""
    for geom in [*spec.geoms]:
        geom.material = ""
        if not (_is_solid(geom) or (geom.mass != 0 and _moves(geom.parent))):
            spec.delete(geom)
    shapes = {geom.meshname for geom in spec.geoms}
    unused = [mesh for mesh in spec.meshes if mesh.name not in shapes]
    for part in [*spec.lights, *spec.cameras, *spec.materials, *spec.textures, *unused]:
        spec.delete(part)


def _is_solid(geom: mujoco.MjsGeom) -> bool:
    return bool(geom.contype or geom.conaffinity)


def _write_inertias(spec: mujoco.MjSpec) -> None:
    """Gives each moving body the inertia of its shapes as numbers, so that the shapes can go."""
    model = spec.compile()
    for body in spec.bodies:
        if any(geom.mass for geom in body.geoms) and _moves(body):
            i = model.body(body.name).id
            body.mass, body.inertia = model.body_mass[i], model.body_inertia[i]
            body.ipos, body.iquat = model.body_ipos[i], model.body_iquat[i]
            body.explicitinertial = True


def _moves(body: mujoco.MjsBody) -> bool:
    while body.name != "world":
        if body.joints:
            return True
        body = body.parent
    return False
