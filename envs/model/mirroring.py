"""The left arm: the mirror image of any model specification in its x-z plane."""

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


def _reflect_pose(
    part: mujoco.MjsBody | mujoco.MjsFrame | mujoco.MjsGeom | mujoco.MjsSite,
) -> None:
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
