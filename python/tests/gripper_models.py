"""MuJoCo models with the shapes of public grippers, each with a hand-written scene.

Numbers are facts of public files: mujoco_menagerie robotiq_2f85/2f85.xml (commit 1b428b08), franka_ros franka_description
(commits 4e8558dd and b2a62ff6), hand_models_hub DP-Flex_closed_kinematics.xml (commit f6a2ab20). Inertias that these files lack or
leave as placeholders are assumed.
"""

from __future__ import annotations

from convert_models import Model


def _inertial(com: str, mass: float, inertia: float) -> str:
    return f'<inertial pos="{com}" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>'


def _finger_2f85(side: str) -> str:
    """A finger in the plane y-z of the base; the left one is the right one turned about z."""
    sign, turn = (1, "1 0 0 0") if side == "right" else (-1, "0 0 0 1")
    pad = f'<body name="{side}_pad" pos="0 -0.0189 0.01352">{_inertial("0 -0.0025 0.0185", 0.0035, 3.64583e-07)}'
    pad += f'<geom name="{side}_pad" type="box" pos="0 -0.0026 0.01875" size="0.011 0.004 0.01875" mass="0" friction="0.7"/></body>'
    coupler = f'<body name="{side}_coupler" pos="0 0.0315 -0.0041"><joint name="{side}_coupler" axis="1 0 0"/>{_inertial("0 0.00301209 0.0232175", 0.0140974, 3.52216e-6)}</body>'
    driver = f'<joint name="{side}_driver" axis="1 0 0" range="-0.5 0.8" armature="0.005" damping="0.1"/>{_inertial("0 0.0177547 0.00107314", 0.00899563, 1.72352e-6)}{coupler}'
    follower = f'<joint name="{side}_follower" axis="1 0 0" pos="0 -0.018 0.0065"/>{_inertial("0 -0.011046 0.0124786", 0.0125222, 2.67415e-6)}{pad}'
    follower = f'<body name="{side}_follower" pos="0 0.055 0.0375">{follower}</body>'
    link = f'<joint name="{side}_spring_link" axis="1 0 0" stiffness="0.05" springref="2.62" damping="0.00125"/>{_inertial("0 0.0181624 0.0212658", 0.0221642, 6.71733e-6)}{follower}'
    first = f'<body name="{side}_driver" pos="0 {sign * 0.0306011} 0.054904" quat="{turn}">{driver}</body>'
    return first + f'<body name="{side}_spring_link" pos="0 {sign * 0.0132} 0.0609" quat="{turn}">{link}</body>'


F85 = Model(
    '<mujoco model="like 2f85"><compiler angle="radian" autolimits="true"/><option gravity="0 0 -9.81"/><worldbody><body name="base" pos="0.1 0.2 0.3">'
    f'<geom type="cylinder" size="0.03 0.02" mass="0.5" contype="0" conaffinity="0"/>{_finger_2f85("right")}{_finger_2f85("left")}</body></worldbody>'
    '<tendon><fixed name="split"><joint joint="right_driver" coef="0.5"/><joint joint="left_driver" coef="0.5"/></fixed></tendon>'
    "<equality>"
    + "".join(f'<connect name="{side}_tip" anchor="0 0 0" body1="{side}_follower" body2="{side}_coupler"/>' for side in ("right", "left"))
    + '<joint name="worm" joint1="right_driver" joint2="left_driver" polycoef="0 1 0 0 0"/></equality>'
    '<actuator><general name="fingers" tendon="split" biastype="affine" forcerange="-5 5" ctrlrange="0 255" gainprm="0.3137255 0 0" biasprm="0 -100 -10"/></actuator>'
    '<keyframe><key name="open" qpos="0 0 0 0 0 0 0 0" ctrl="8"/></keyframe></mujoco>',
    """kind = "mechanism"
duration = "50 ms"
gravity = ["0 m/s^2", "-9.81 m/s^2"]

[mirror]
from = "right"
to = "left"

[bodies.right_driver]
mass = "8.99563 g"
inertia = "1723.52 g*mm^2"
com = ["17.7547 mm", "1.07314 mm"]
guess = { at = ["30.6011 mm", "54.904 mm"] }

[bodies.right_coupler]
mass = "14.0974 g"
inertia = "3522.16 g*mm^2"
com = ["3.01209 mm", "23.2175 mm"]
guess = { at = ["62.1011 mm", "50.804 mm"] }

[bodies.right_link]
mass = "22.1642 g"
inertia = "6717.33 g*mm^2"
com = ["18.1624 mm", "21.2658 mm"]
guess = { at = ["13.2 mm", "60.9 mm"] }

[parameters]                    # follower and pad, which is fixed to it
follower = "12.5222 g"
pad = "3.5 g"
x = "= (-11.046 mm * follower - 21.4 mm * pad) / (follower + pad)"
y = "= (12.4786 mm * follower + 32.02 mm * pad) / (follower + pad)"
apart = "= hypot(10.354 mm, 19.5414 mm)"

[bodies.right_follower]
mass = "= follower + pad"
inertia = "= 2674.15 g*mm^2 + 364.583 g*mm^2 + follower * pad / (follower + pad) * apart^2"
com = ["= x", "= y"]
guess = { at = ["68.2 mm", "98.4 mm"] }

[joints.right_driver]
bodies = ["ground", "right_driver"]
at = ["30.6011 mm", "54.904 mm"]
start = "0 rad"
damping = "0.1 N*m*s/rad"
armature = "0.005 kg*m^2"

[joints.right_coupler]
bodies = ["right_driver", "right_coupler"]
at = ["62.1011 mm", "50.804 mm"]
start = "0 rad"

[joints.right_link]
bodies = ["ground", "right_link"]
at = ["13.2 mm", "60.9 mm"]
damping = "0.00125 N*m*s/rad"

[joints.right_follower]
bodies = ["right_link", "right_follower"]
at = ["50.2 mm", "104.9 mm"]

[joints.right_tip]
bodies = ["right_coupler", "right_follower"]
at = ["68.2 mm", "98.4 mm"]

[springs.right_link]
joint = "right_link"
stiffness = "0.05 N*m/rad"
rest = "2.62 rad"

[couplings.worm]
joints = ["right_driver", "left_driver"]
factors = [1, -1]

[actuators.fingers]
joints = ["right_driver", "left_driver"]
factors = [0.5, 0.5]
target = "= 0.003137255 * 8 * 1 rad"
kp = "100 N*m/rad"
kd = "10 N*m*s/rad"
limit = "5 N*m"
""",
    {
        f"{side}_{joint}": f"{side}_{column}_rad"
        for side in ("right", "left")
        for joint, column in (("driver", "driver"), ("coupler", "coupler"), ("spring_link", "link"), ("follower", "follower"))
    },
)


def _finger_franka(side: str) -> str:
    turn = "1 0 0 0" if side == "left" else "0 0 0 1"
    boxes = (("rubber", "0 0.00758 0.04525", "0.00875 0.0076 0.00925"), ("tip", "0 0.0015 0.06", "0.009 0.0015 0.0075"))
    pads = "".join(f'<geom name="{side}_{name}" type="box" pos="{pos}" size="{size}" mass="0"/>' for name, pos, size in boxes)
    joint = f'<joint name="{side}" type="slide" axis="0 1 0" range="0 0.04" damping="0.3" armature="0.1"/>'
    return f'<body name="{side}" pos="0 0 0.0584" quat="{turn}">{joint}{_inertial("0 0.002 0.02", 0.015, 2.375e-6)}{pads}</body>'


FRANKA = Model(
    '<mujoco model="like franka"><compiler angle="radian" autolimits="true"/><option gravity="0 0 0"/><worldbody><body name="hand" pos="0 0 0.4" quat="0 1 0 0">'
    f'<geom type="box" size="0.03 0.1 0.03" pos="0 0 0.03" mass="0.73" contype="0" conaffinity="0"/>{_finger_franka("left")}{_finger_franka("right")}</body></worldbody>'
    '<tendon><fixed name="split"><joint joint="left" coef="0.5"/><joint joint="right" coef="0.5"/></fixed></tendon>'
    '<equality><joint name="mimic" joint1="left" joint2="right" polycoef="0 1 0 0 0"/></equality>'
    '<actuator><general name="fingers" tendon="split" biastype="affine" forcerange="-100 100" ctrlrange="0 255" gainprm="0.01568627451 0 0" biasprm="0 -100 -10"/></actuator>'
    '<keyframe><key name="half" qpos="0.02 0.02" ctrl="200"/></keyframe></mujoco>',
    # The hand hangs: y of the scene is z of the world.
    """kind = "mechanism"
duration = "50 ms"

[bodies.left]
mass = "15 g"
inertia = "2375 g*mm^2"
com = ["-2 mm", "-20 mm"]
guess = { at = ["-20 mm", "341.6 mm"] }

[bodies.right]
mass = "15 g"
inertia = "2375 g*mm^2"
com = ["2 mm", "-20 mm"]
guess = { at = ["20 mm", "341.6 mm"] }

[joints.left]
type = "prismatic"
bodies = ["ground", "left"]
points = [["0 mm", "341.6 mm"], ["0 mm", "0 mm"]]
axis = "180 deg"
start = "20 mm"
damping = "0.3 N*s/m"
armature = "0.1 kg"

[joints.right]
type = "prismatic"
bodies = ["ground", "right"]
points = [["0 mm", "341.6 mm"], ["0 mm", "0 mm"]]
damping = "0.3 N*s/m"
armature = "0.1 kg"

[couplings.mimic]
joints = ["left", "right"]
factors = [1, -1]

[actuators.fingers]
joints = ["left", "right"]
factors = [0.5, 0.5]
target = "= 0.0001568627451 * 200 * 1 m"
kp = "100 N/m"
kd = "10 N*s/m"
limit = "100 N"
""",
    {"left": "left_position_m", "right": "right_position_m"},
)


# The link of the palm is turned by a rounded quaternion, and its frame is that of the scene: x is y of the link, and y is z.
DP_FLEX = Model(
    '<mujoco model="like dp-flex"><compiler angle="degree" autolimits="true"/><option gravity="0 0 0"/><default><joint damping="0.02" armature="1e-5"/></default>'
    '<worldbody><body name="palm" pos="0.02 0.01 0.1"><geom type="sphere" size="0.01" contype="0" conaffinity="0"/>'
    '<body name="flexion" quat="0.7071068 0 0.7071068 0"><joint name="flexion" axis="0 0 1" range="-90 90"/>'
    f"{_inertial('-0.007468 0.022758 0', 0.028728, 6e-6)}"
    '<body name="distal" pos="-0.0069587 0.049513 0"><joint name="distal" axis="0 0 1" range="-90 70" stiffness="0.1" springref="-74"/>'
    f"{_inertial('-0.001736 0.022618 0.003', 0.014125, 4.2e-6)}"
    '<site name="arm" pos="0.0220975 0.0116918 0.004"/></body></body>'
    '<body name="crank" pos="0 0.034 -0.02" quat="0.7071068 0 0.7071068 0"><joint name="crank" axis="0 0 1"/>'
    f"{_inertial('0.026976 0.011076 0', 0.006624, 2.1e-6)}"
    '<body name="pusher" pos="0.057068 0.024234 0"><joint name="pusher" axis="0 0 1"/>'
    f"{_inertial('-0.027507 0.00132 0', 0.009377, 3e-6)}"
    # The published anchors close to 0.1 mm; here they close exactly.
    '<site name="end" pos="-0.0619292 0.0029708 0.004"/></body></body></body></worldbody>'
    '<equality><connect name="arm" site1="end" site2="arm"/></equality>'
    '<actuator><position name="servo" joint="crank" kp="2" ctrlrange="0 1.5"/></actuator><keyframe><key qpos="0 0 0 0" ctrl="0.3"/></keyframe></mujoco>',
    """kind = "mechanism"
duration = "50 ms"

[bodies.flexion]
mass = "28.728 g"
inertia = "6000 g*mm^2"
com = ["-7.468 mm", "22.758 mm"]

[bodies.distal]
mass = "14.125 g"
inertia = "4200 g*mm^2"
com = ["-1.736 mm", "22.618 mm"]
guess = { at = ["-6.9587 mm", "49.513 mm"] }

[bodies.crank]
mass = "6.624 g"
inertia = "2100 g*mm^2"
com = ["26.976 mm", "11.076 mm"]
guess = { at = ["20 mm", "34 mm"] }

[bodies.pusher]
mass = "9.377 g"
inertia = "3000 g*mm^2"
com = ["-27.507 mm", "1.32 mm"]
guess = { at = ["77.068 mm", "58.234 mm"] }

[joints.flexion]
bodies = ["ground", "flexion"]
at = ["0 mm", "0 mm"]
damping = "0.02 N*m*s/rad"
armature = "1e-5 kg*m^2"
start = "0 deg"

[joints.distal]
bodies = ["flexion", "distal"]
at = ["-6.9587 mm", "49.513 mm"]
damping = "0.02 N*m*s/rad"
armature = "1e-5 kg*m^2"

[joints.crank]
bodies = ["ground", "crank"]
at = ["20 mm", "34 mm"]
damping = "0.02 N*m*s/rad"
armature = "1e-5 kg*m^2"
start = "0 deg"

[joints.pusher]
bodies = ["crank", "pusher"]
at = ["77.068 mm", "58.234 mm"]
damping = "0.02 N*m*s/rad"
armature = "1e-5 kg*m^2"

[joints.arm]
bodies = ["pusher", "distal"]
points = [["-61.9292 mm", "2.9708 mm"], ["22.0975 mm", "11.6918 mm"]]

[springs.distal]
joint = "distal"
stiffness = "0.1 N*m/rad"
rest = "-74 deg"

[actuators.servo]
joint = "crank"
target = "0.3 rad"
kp = "2 N*m/rad"
""",
    {"flexion": "flexion_rad", "distal": "distal_rad", "crank": "crank_rad", "pusher": "pusher_rad"},
)

GRIPPERS = {"2F-85": F85, "Franka": FRANKA, "DP-Flex": DP_FLEX}
