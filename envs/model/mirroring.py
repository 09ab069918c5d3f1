"""The left arm: the mirror image of any model specification in its x-z plane."""

import mujoco
import numpy as np

_POLAR = np.array([1.0, -1.0, 1.0])  # positions and directions
_AXIAL = np.array([-1.0, 1.0, -1.0])  # rotation axes, whose sense a mirror reverses
_QUATERNION = np.array([1.0, *_AXIAL])
_FULL_INERTIA = np.array([1.0, 1.0, 1.0, -1.0, 1.0, -1.0])  # xx, yy, zz, xy, xz, yz
_Kind = mujoco.mjtOrientation


def mirror(spec: mujoco.MjSpec) -> None:
    """Reflects everything in `spec` from y to -y, in place; all names stay.

    Joints keep the meaning of their angles, so the image moves as the mirror image of the motion,
    with the same dynamics in the joints' coordinates. Cameras show the mirrored picture.
    Meshes and textures are not reflected: they must be symmetric in their own x-z plane.
    """
    for body in spec.bodies:
        body.pos = body.pos * _POLAR
        body.ipos = body.ipos * _POLAR
        body.iquat = body.iquat * _QUATERNION
        body.fullinertia = body.fullinertia * _FULL_INERTIA
        _reflect_orientation(body)
        for part in (*body.geoms, *body.sites):
            part.pos = part.pos * _POLAR
            part.fromto = part.fromto * np.tile(_POLAR, 2)
            _reflect_orientation(part)
        for joint in body.joints:
            joint.pos = joint.pos * _POLAR
            joint.axis = joint.axis * _AXIAL
        for light in body.lights:
            light.pos = light.pos * _POLAR
            light.dir = light.dir * _POLAR
        for camera in body.cameras:
            camera.pos = camera.pos * _POLAR
            _reflect_camera(camera)


def _reflect_orientation(part: mujoco.MjsBody | mujoco.MjsGeom | mujoco.MjsSite) -> None:
    kind = part.alt.type
    if kind == _Kind.mjORIENTATION_QUAT:
        part.quat = part.quat * _QUATERNION
    elif kind == _Kind.mjORIENTATION_EULER:
        part.alt.euler = part.alt.euler * _AXIAL
    elif kind == _Kind.mjORIENTATION_AXISANGLE:
        part.alt.axisangle = part.alt.axisangle * np.array([*_AXIAL, 1.0])
    elif kind == _Kind.mjORIENTATION_ZAXIS:
        part.alt.zaxis = part.alt.zaxis * _POLAR
    else:
        # The mirror image of the y axis is the frame's -y axis: a frame stays right-handed.
        part.alt.xyaxes = part.alt.xyaxes * np.array([*_POLAR, *-_POLAR])


def _reflect_camera(camera: mujoco.MjsCamera) -> None:
    """Reflects what a camera looks at; its x axis, to the right of the picture, changes sides."""
    if camera.alt.type != _Kind.mjORIENTATION_XYAXES:
        raise NotImplementedError(f"camera {camera.name!r} is not oriented by its xyaxes")
    camera.alt.xyaxes = camera.alt.xyaxes * np.array([*-_POLAR, *_POLAR])
