"""Other forms of a specification: the left arm, and one without drawings."""

from typing import Any

import mujoco
import numpy as np

_POLAR = np.array([1.0, -1.0, 1.0])  # positions and directions
_AXIAL = np.array([-1.0, 1.0, -1.0])  # rotation axes, whose sense a mirror reverses
_QUATERNION = np.array([1.0, *_AXIAL])
_FULL_INERTIA = np.array([1.0, 1.0, 1.0, -1.0, 1.0, -1.0])  # xx, yy, zz, xy, xz, yz


def mirror(spec: mujoco.MjSpec) -> None:
    """Reflects everything in `spec` from y to -y, in place; all names stay.

    Hinges and slides keep the meaning of their coordinates, so the image moves as the mirror image
    of the motion, with the same dynamics in these coordinates. Cameras show the mirrored picture.
    Meshes and textures are not reflected: they must be symmetric in their own x-z plane.
    """
    for frame in spec.frames:
        _reflect_pose(frame)
    for body in spec.bodies:
        _reflect_pose(body)
        body.ipos = body.ipos * _POLAR
        body.iquat = body.iquat * _QUATERNION
        _reflect_orientation(body.ialt)
        body.fullinertia = body.fullinertia * _FULL_INERTIA
        for part in (*body.geoms, *body.sites):
            _reflect_pose(part)
            part.fromto = part.fromto * np.tile(_POLAR, 2)
        for joint in body.joints:
            slides = joint.type == mujoco.mjtJoint.mjJNT_SLIDE
            joint.pos = joint.pos * _POLAR
            joint.axis = joint.axis * (_POLAR if slides else _AXIAL)
        for light in body.lights:
            light.pos = light.pos * _POLAR
            light.dir = light.dir * _POLAR
        for camera in body.cameras:
            camera.pos = camera.pos * _POLAR
            _reflect_camera(camera)
    for actuator in spec.actuators:
        if actuator.trntype == mujoco.mjtTrn.mjTRN_SITE:
            actuator.gear = actuator.gear * np.array([*_POLAR, *_AXIAL])


def _reflect_pose(part: mujoco.MjsBody | mujoco.MjsFrame | mujoco.MjsGeom | mujoco.MjsSite) -> None:
    part.pos = part.pos * _POLAR
    part.quat = part.quat * _QUATERNION
    _reflect_orientation(part.alt)


def _reflect_orientation(given: mujoco.MjsOrientation) -> None:
    """Reflects an orientation that is given in any other way than as a quaternion."""
    given.euler = given.euler * _AXIAL
    given.axisangle = given.axisangle * np.array([*_AXIAL, 1.0])
    given.zaxis = given.zaxis * _POLAR
    # The mirror image of the y axis is the frame's -y axis: a frame stays right-handed.
    given.xyaxes = given.xyaxes * np.array([*_POLAR, *-_POLAR])


def _reflect_camera(camera: mujoco.MjsCamera) -> None:
    """Reflects the view of a camera, whose x axis (to the right of the picture) changes sides."""
    if camera.alt.type != mujoco.mjtOrientation.mjORIENTATION_XYAXES:
        raise NotImplementedError(f"camera {camera.name!r} is not oriented by its xyaxes")
    camera.alt.xyaxes = camera.alt.xyaxes * np.array([*-_POLAR, *_POLAR])


ARENA = 200_000  # [bytes], memory for contacts: an arm needs 14,400, MuJoCo reserves 13 MB


def taken_keyframes(spec: mujoco.MjSpec) -> list[dict[str, Any]]:
    """Removes all keyframes; returns their arguments of `add_key`.

    MuJoCo checks the sizes of keyframes at every deletion of a part, and counts too few inputs.
    """
    fields = ("qpos", "act", "ctrl")
    found = [
        {"name": key.name} | {field: list(getattr(key, field)) for field in fields}
        for key in spec.keys
    ]
    for key in [*spec.keys]:
        spec.delete(key)
    return found


def make_lean(spec: mujoco.MjSpec) -> None:
    """Removes geoms without mass and contact, empty bodies, lights, cameras and pictures, in place.

    Joints, sensors, actuators and keyframes stay unchanged.
    """
    keyframes = taken_keyframes(spec)
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
    for keyframe in keyframes:
        spec.add_key(**keyframe)
    spec.memory = ARENA


def remove_drawings(spec: mujoco.MjSpec) -> None:
    """Removes the parts that are only drawn, in place, after the keyframes have been removed."""
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
