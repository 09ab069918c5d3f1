"""Films the same reaches of two suited wearers in microgravity: motors off, and compensation."""

from pathlib import Path

import numpy as np
from activesuit.envs import ArmEnv
from activesuit.envs.policies import make_policy
from activesuit.scripts.film import film_writer
from PIL import Image, ImageDraw, ImageFont

STRIDE, SECONDS, SIDE = 6, 7.0, 400  # control periods between pictures, length, pixels
POLICIES = {"none": "motors off", "compensation": "with assistance"}
SMALL, LARGE = (ImageFont.load_default(size) for size in (16, 20))
MOTORS = [1, 2]  # joints with a motor: shoulder flexion and elbow
FULL = 25.0  # N·m, the longest bar


def filmed(name):
    """Returns pictures of an episode, and the sum of the wearer's torques at each [N·m]."""
    env = ArmEnv(
        "ArmTracking",
        **{"suit": "emu-like", "gravity": "microgravity"},
        **{"render_mode": "rgb_array", "width": 2 * SIDE, "height": 2 * SIDE},
    )
    policy = make_policy(name, env)
    observation, _ = env.reset(seed=3)
    policy.reset()
    pictures, torques = [], []
    for period in range(round(SECONDS / env.control_dt)):
        observation, _, _, ended, info = env.step(policy.act(observation))
        torques.append(np.abs(info["human_torque"][MOTORS]).sum())
        if period % STRIDE == 0:
            pictures.append(Image.fromarray(env.render()).resize((SIDE, SIDE)))
        if ended:
            break
    smooth = np.convolve(torques, np.ones(20) / 20, "same")  # over 0.2 s
    return pictures, smooth[::STRIDE]


def framed(picture, title, torque):
    """Returns a picture with its title, and a bar of the wearer's torque below."""
    frame = Image.new("RGB", (SIDE, SIDE + 40), "#20242c")
    frame.paste(picture)
    draw = ImageDraw.Draw(frame)
    draw.text((12, 8), title, "white", LARGE)
    draw.text((12, SIDE + 10), f"wearer: {torque:2.0f} N·m", "white", SMALL)
    draw.rectangle((175, SIDE + 12, 176 + 210 * min(1, torque / FULL), SIDE + 28), "#ff5a1f")
    return np.asarray(frame)


columns = [
    [framed(picture, title, torque) for picture, torque in zip(*filmed(name), strict=True)]
    for name, title in POLICIES.items()
]
frames = [np.hstack(pair) for pair in zip(*columns, strict=True)]
path = Path("motion.gif")
film_writer(path)(path, frames, 0.01 * STRIDE)
