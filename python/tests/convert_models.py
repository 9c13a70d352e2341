"""Small MuJoCo models, each with a hand-written scene of the same mechanism: a wrong rule of the conversion shows in one of them.

The scenes are written from the same numbers by the rules of scene files, and not by the conversion.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Model:
    """A MuJoCo model and the same mechanism as a scene."""

    mjcf: str
    scene: str
    joints: dict[str, str]
    """Joints of the model with their columns in the hand-written scene."""
    tolerance: float = 1e-8
    """Largest difference from MuJoCo's planar copy with rigid constraints after 50 ms, rad or m."""


def mjcf(world: str, rest: str = "", compiler: str = "") -> str:
    """A model without gravity, in radians."""
    return f'<mujoco><compiler angle="radian" {compiler}/><option gravity="0 0 0"/><worldbody>{world}</worldbody>{rest}</mujoco>'


# A link of 20 g in the plane x-z: x of the scene is x, y is z, and the normal is -y. A positive turn about the axis 0 -1 0 is therefore
# counter-clockwise.
LINK = '<inertial pos="0.03 0 0.002" mass="0.02" diaginertia="8e-6 8e-6 8e-6"/>'
LINK_TOML = 'mass = "20 g"\ninertia = "8000 g*mm^2"\ncom = ["30 mm", "2 mm"]\n'


def scene(text: str) -> str:
    """A scene of a mechanism."""
    return f'kind = "mechanism"\nduration = "50 ms"\n{text}'


MODELS = {
    # ref is the coordinate of the drawn position, and not a target.
    "ref": Model(
        mjcf(
            f'<body name="link"><joint name="pin" axis="0 -1 0" ref="0.3" range="-4 4"/>{LINK}</body>',
            '<actuator><position name="servo" joint="pin" kp="0.4"/></actuator><keyframe><key qpos="0.3" ctrl="0.8"/></keyframe>',
        ),
        scene(
            f'[bodies.link]\n{LINK_TOML}[joints.pin]\nbodies = ["ground", "link"]\npoints = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]\noffset = "-0.3 rad"\nstart = "0.3 rad"\n'
            '[actuators.servo]\njoint = "pin"\ntarget = "0.8 rad"\nkp = "0.4 N*m/rad"\n'
        ),
        {"pin": "pin_rad"},
    ),
    # The rest of the spring is springref, and not ref.
    "springref": Model(
        mjcf(
            f'<body name="link"><joint name="pin" axis="0 -1 0" ref="0.3" stiffness="0.2" springref="-0.4" damping="1e-4" armature="3e-6"/>{LINK}</body>'
        ),
        scene(
            f'[bodies.link]\n{LINK_TOML}[joints.pin]\nbodies = ["ground", "link"]\npoints = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]\noffset = "-0.3 rad"\nstart = "0.3 rad"\n'
            'damping = "1e-4 N*m*s/rad"\narmature = "3e-6 kg*m^2"\n[springs.s]\njoint = "pin"\nstiffness = "0.2 N*m/rad"\nrest = "-0.4 rad"\n'
        ),
        {"pin": "pin_rad"},
    ),
    # The anchor is pos of the joint in its body, not the origin of the body.
    "jnt_pos": Model(
        mjcf(
            f'<body name="link" pos="0.01 0 0.02"><joint name="pin" pos="-0.004 0.3 0.005" axis="0 -1 0"/>{LINK}'
            f'<body name="tip" pos="0.06 0 0"><joint name="knuckle" pos="0.002 0 0.001" axis="0 -1 0"/>{LINK}</body></body>',
            '<actuator><motor name="m" joint="pin"/></actuator><keyframe><key qpos="0 0" ctrl="0.05"/></keyframe>',
        ),
        scene(
            f'[bodies.link]\n{LINK_TOML}guess = {{ at = ["10 mm", "20 mm"] }}\n[bodies.tip]\n{LINK_TOML}guess = {{ at = ["70 mm", "20 mm"] }}\n'
            '[joints.pin]\nbodies = ["ground", "link"]\nat = ["6 mm", "25 mm"]\nstart = "0 rad"\n'
            '[joints.knuckle]\nbodies = ["link", "tip"]\nat = ["72 mm", "21 mm"]\nstart = "0 rad"\n[actuators.m]\njoint = "pin"\ntorque = "0.05 N*m"\n'
        ),
        {"pin": "pin_rad", "knuckle": "knuckle_rad"},
    ),
    # Principal axes of inertia: about the normal -y acts 5e-6 cos^2 + 9e-6 sin^2 of 30 deg about x, = 6e-6.
    "iquat": Model(
        mjcf(
            '<body name="link"><joint name="pin" axis="0 -1 0"/>'
            '<inertial pos="0.03 0.01 0.002" mass="0.02" diaginertia="7e-6 5e-6 9e-6" quat="0.9659258262890683 0.25881904510252074 0 0"/></body>',
            '<actuator><motor name="m" joint="pin"/></actuator><keyframe><key qpos="0" ctrl="0.02"/></keyframe>',
        ),
        scene(
            '[bodies.link]\nmass = "20 g"\ninertia = "6000 g*mm^2"\ncom = ["30 mm", "2 mm"]\n'
            '[joints.pin]\nbodies = ["ground", "link"]\nat = ["0 mm", "0 mm"]\nstart = "0 rad"\n[actuators.m]\njoint = "pin"\ntorque = "0.02 N*m"\n'
        ),
        {"pin": "pin_rad"},
    ),
    # A body without joint, with the mass of its geom: 60 x 20 x 10 mm of 1000 kg/m^3, 12 g, turned by 90 deg about y.
    "welded merge": Model(
        mjcf(
            f'<body name="link"><joint name="pin" axis="0 -1 0"/>{LINK}'
            '<body name="pad" pos="0.05 0 0.01" euler="0 1.5707963267948966 0"><geom name="pad" type="box" size="0.03 0.01 0.005" density="1000"/></body></body>',
            '<actuator><motor name="m" joint="pin"/></actuator><keyframe><key qpos="0" ctrl="0.03"/></keyframe>',
        ),
        # The two parts as two bodies that one joint and one coupling hold together would be one way; here is the parallel axis theorem.
        scene(
            '[bodies.link]\nmass = "32 g"\ninertia = "15180 g*mm^2"\ncom = ["37.5 mm", "5 mm"]\n'
            '[joints.pin]\nbodies = ["ground", "link"]\nat = ["0 mm", "0 mm"]\nstart = "0 rad"\n[actuators.m]\njoint = "pin"\ntorque = "0.03 N*m"\n'
        ),
        {"pin": "pin_rad"},
    ),
    # A gear multiplies the force and the length: gains with its square, the target by its inverse, the limit once.
    "gear": Model(
        mjcf(
            f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}</body><body name="b" pos="0.2 0 0"><joint name="b" axis="0 -1 0"/>{LINK}</body>'
            f'<body name="c" pos="0.4 0 0"><joint name="c" axis="0 -1 0"/>{LINK}</body>',
            '<actuator><motor name="a" joint="a" gear="-3"/><position name="b" joint="b" gear="4" kp="0.02" kv="2e-5"/>'
            '<position name="c" joint="c" gear="4" kp="0.02" forcerange="-0.005 0.005"/></actuator><keyframe><key qpos="0 0 0" ctrl="0.01 2 2"/></keyframe>',
        ),
        scene(
            "".join(
                f'[bodies.{name}]\n{LINK_TOML}guess = {{ at = ["{x} mm", "0 mm"] }}\n[joints.{name}]\nbodies = ["ground", "{name}"]\nat = ["{x} mm", "0 mm"]\nstart = "0 rad"\n'
                for name, x in (("a", 0), ("b", 200), ("c", 400))
            )
            + '[actuators.a]\njoint = "a"\ntorque = "-0.03 N*m"\n[actuators.b]\njoint = "b"\ntarget = "0.5 rad"\nkp = "0.32 N*m/rad"\nkd = "3.2e-4 N*m*s/rad"\n'
            '[actuators.c]\njoint = "c"\ntarget = "0.5 rad"\nkp = "0.32 N*m/rad"\nlimit = "0.02 N*m"\n'
        ),
        {"a": "a_rad", "b": "b_rad", "c": "c_rad"},
    ),
    # A sum of joints drives both; its spring and its inertia act on the sum.
    "coef": Model(
        mjcf(
            f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}<body name="b" pos="0.06 0 0"><joint name="b" axis="0 -1 0"/>{LINK}</body></body>',
            '<tendon><fixed name="split" stiffness="0.1" springlength="0.2" damping="1e-4" armature="2e-5"><joint joint="a" coef="0.485"/><joint joint="b" coef="-0.3"/></fixed></tendon>'
            '<actuator><position name="m" tendon="split" kp="2" kv="0.01" gear="1.5" forcerange="-0.4 0.4"/></actuator><keyframe><key qpos="0 0" ctrl="0.3"/></keyframe>',
        ),
        scene(
            f'[bodies.a]\n{LINK_TOML}[joints.a]\nbodies = ["ground", "a"]\nat = ["0 mm", "0 mm"]\nstart = "0 rad"\n'
            f'[bodies.b]\n{LINK_TOML}guess = {{ at = ["60 mm", "0 mm"] }}\n[joints.b]\nbodies = ["a", "b"]\nat = ["60 mm", "0 mm"]\nstart = "0 rad"\n'
            '[springs.s]\njoints = ["a", "b"]\nfactors = [0.485, -0.3]\nstiffness = "0.1 N*m/rad"\nrest = "0.2 rad"\ndamping = "1e-4 N*m*s/rad"\n'
            '[rotors.r]\njoints = ["a", "b"]\nfactors = [0.485, -0.3]\ninertia = "2e-5 kg*m^2"\n'
            '[actuators.m]\njoints = ["a", "b"]\nfactors = [0.485, -0.3]\ntarget = "0.2 rad"\nkp = "4.5 N*m/rad"\nkd = "0.0225 N*m*s/rad"\nlimit = "0.6 N*m"\n'
        ),
        {"a": "a_rad", "b": "b_rad"},
    ),
    # dampratio 0.5: kd = 2 * 0.5 * sqrt(kp * m), with the inertia about the pin, 8e-6 + 0.02 (0.03^2 + 0.002^2) = 2.608e-5 kg m^2.
    "dampratio": Model(
        mjcf(
            f'<body name="link"><joint name="pin" axis="0 -1 0"/>{LINK}</body>',
            '<actuator><position name="servo" joint="pin" kp="0.4" dampratio="0.5"/></actuator><keyframe><key qpos="0" ctrl="0.8"/></keyframe>',
        ),
        scene(
            f'[parameters]\nm = "2.608e-5 kg*m^2"\n[bodies.link]\n{LINK_TOML}[joints.pin]\nbodies = ["ground", "link"]\nat = ["0 mm", "0 mm"]\nstart = "0 rad"\n'
            f'[actuators.servo]\njoint = "pin"\ntarget = "0.8 rad"\nkp = "0.4 N*m/rad"\nkd = "{(0.4 * 2.608e-5) ** 0.5!r} N*m*s/rad"\n'
        ),
        {"pin": "pin_rad"},
    ),
    # An axis that points into the plane: coordinate, spring, torque and coupling keep their signs.
    "sign": Model(
        mjcf(
            f'<body name="a"><joint name="a" axis="0 1 0" ref="0.2" stiffness="0.3" springref="0.5"/>{LINK}'
            f'<body name="tip" pos="0.06 0 0"><joint name="tip" axis="0 -1 0" damping="1e-4"/>{LINK}</body></body>',
            '<equality><joint joint1="tip" joint2="a" polycoef="0.05 -0.7 0 0 0"/></equality>'
            '<actuator><motor name="m" joint="a"/></actuator><keyframe><key qpos="0.2 0.05" ctrl="0.06"/></keyframe>',
        ),
        # q of the drawn position is 0.2; the relation is tip - 0 = 0.05 - 0.7 (a - 0.2).
        scene(
            f'[bodies.a]\n{LINK_TOML}[bodies.tip]\n{LINK_TOML}guess = {{ at = ["60 mm", "0 mm"] }}\n'
            '[joints.a]\nbodies = ["a", "ground"]\npoints = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]\noffset = "-0.2 rad"\nstart = "0.2 rad"\n'
            '[joints.tip]\nbodies = ["a", "tip"]\npoints = [["60 mm", "0 mm"], ["0 mm", "0 mm"]]\ndamping = "1e-4 N*m*s/rad"\n'
            '[springs.a]\njoint = "a"\nstiffness = "0.3 N*m/rad"\nrest = "0.5 rad"\n'
            '[couplings.c]\njoints = ["tip", "a"]\nfactors = [1, 0.7]\nvalue = "0.19 rad"\n[actuators.m]\njoint = "a"\ntorque = "0.06 N*m"\n'
        ),
        {"a": "a_rad", "tip": "tip_rad"},
    ),
    # Slides with ref, in a body that is turned by 30 deg, and a rate of the servo.
    "slide": Model(
        mjcf(
            '<body name="base" euler="0 -0.5235987755982988 0"><geom size="0.01"/><body name="jaw" pos="0.02 0 0.05">'
            f'<joint name="jaw" type="slide" axis="1 0 0" ref="0.01" stiffness="20" springref="0.03"/>{LINK}'
            f'<body name="tip" pos="0 0 0.04"><joint name="tip" axis="0 -1 0"/>{LINK}</body></body></body>',
            '<actuator><velocity name="v" joint="jaw" kv="3"/></actuator><keyframe><key qpos="0.01 0.4" ctrl="0.2"/></keyframe>',
        ),
        # The base is turned counter-clockwise; the drawn position of the jaw has the coordinate 10 mm.
        scene(
            '[parameters]\nturn = "30 deg"\n[bodies.jaw]\nmass = "20 g"\ninertia = "8000 g*mm^2"\ncom = ["30 mm", "2 mm"]\n'
            'guess = { at = ["= 20 mm * cos(turn) - 50 mm * sin(turn)", "= 20 mm * sin(turn) + 50 mm * cos(turn)"], angle = "= turn" }\n'
            f'[bodies.tip]\n{LINK_TOML}guess = {{ at = ["= 20 mm * cos(turn) - 90 mm * sin(turn)", "= 20 mm * sin(turn) + 90 mm * cos(turn)"], angle = "= turn + 0.4 rad" }}\n'
            '[joints.jaw]\ntype = "prismatic"\nbodies = ["ground", "jaw"]\naxis = "= turn"\noffset = "= turn"\nstart = "10 mm"\n'
            'points = [["= 10 mm * cos(turn) - 50 mm * sin(turn)", "= 10 mm * sin(turn) + 50 mm * cos(turn)"], ["0 mm", "0 mm"]]\n'
            '[joints.tip]\nbodies = ["jaw", "tip"]\npoints = [["0 mm", "40 mm"], ["0 mm", "0 mm"]]\nstart = "0.4 rad"\n'
            '[springs.jaw]\njoint = "jaw"\nstiffness = "20 N/m"\nrest = "30 mm"\n'
            '[actuators.v]\njoint = "jaw"\ntimes = ["0 s", "1 s"]\ntargets = ["0 mm", "200 mm"]\nkd = "3 N*s/m"\n'
        ),
        {"jaw": "jaw_position_m", "tip": "tip_rad"},
    ),
    # A four-bar that a `connect` closes, by anchor, and by two sites in other places along the normal.
    "connect": Model(
        mjcf(
            f'<body name="crank"><joint name="crank" axis="0 -1 0"/>{LINK}'
            f'<body name="rod" pos="0.02 0 0.03"><joint name="rod" axis="0 -1 0"/>{LINK}<site name="end" pos="0.06 0.004 0.01"/></body></body>'
            f'<body name="rocker" pos="0.07 0 0"><joint name="rocker" axis="0 -1 0" damping="1e-4"/>{LINK}<site name="eye" pos="0.01 0.004 0.04"/></body>',
            '<equality><connect name="pin" site1="end" site2="eye"/></equality><actuator><motor name="m" joint="crank"/></actuator>'
            '<keyframe><key qpos="0 0 0" ctrl="0.05"/></keyframe>',
        ),
        scene(
            f'[bodies.crank]\n{LINK_TOML}[bodies.rod]\n{LINK_TOML}guess = {{ at = ["20 mm", "30 mm"] }}\n[bodies.rocker]\n{LINK_TOML}guess = {{ at = ["70 mm", "0 mm"] }}\n'
            '[joints.crank]\nbodies = ["ground", "crank"]\nat = ["0 mm", "0 mm"]\nstart = "0 rad"\n[joints.rod]\nbodies = ["crank", "rod"]\nat = ["20 mm", "30 mm"]\n'
            '[joints.rocker]\nbodies = ["ground", "rocker"]\nat = ["70 mm", "0 mm"]\ndamping = "1e-4 N*m*s/rad"\n[joints.pin]\nbodies = ["rod", "rocker"]\nat = ["80 mm", "40 mm"]\n'
            '[actuators.m]\njoint = "crank"\ntorque = "0.05 N*m"\n'
        ),
        {"crank": "crank_rad", "rod": "rod_rad", "rocker": "rocker_rad"},
    ),
    # general with an affine bias: force = 0.02 ctrl + 0.3 - 2 l - 0.01 l', ctrl clipped to 20, l = 0.5 q.
    "affine bias": Model(
        mjcf(
            f'<body name="link"><joint name="pin" axis="0 -1 0"/>{LINK}</body>',
            '<actuator><general name="m" joint="pin" gear="0.5" gaintype="fixed" gainprm="0.02" biastype="affine" biasprm="0.3 -2 -0.01" ctrllimited="true" ctrlrange="0 20"/></actuator>'
            '<keyframe><key qpos="0" ctrl="255"/></keyframe>',
        ),
        scene(
            f'[bodies.link]\n{LINK_TOML}[joints.pin]\nbodies = ["ground", "link"]\nat = ["0 mm", "0 mm"]\nstart = "0 rad"\n'
            '[actuators.m]\njoint = "pin"\ntarget = "0.7 rad"\nkp = "0.5 N*m/rad"\nkd = "2.5e-3 N*m*s/rad"\n'
        ),
        {"pin": "pin_rad"},
    ),
    # A cable over the pulley of a joint, with a branch of half the tension; a spring of two points that also pushes.
    "spatial tendon": Model(
        mjcf(
            '<site name="winch" pos="-0.04 0 0.02"/><site name="start" pos="0.25 0 0.03"/><site name="post" pos="0.0 0 0.09"/>'
            f'<body name="a"><joint name="a" axis="0 -1 0" damping="1e-3"/>{LINK}<geom name="pulley" type="cylinder" size="0.008 0.01" euler="1.5707963267948966 0 0" contype="0" conaffinity="0" mass="0"/>'
            '<site name="side" pos="0 0 -0.02"/><site name="hole" pos="0.04 0 0.03"/><site name="lug" pos="0.02 0 0.01"/></body>'
            f'<body name="b" pos="0.3 0 0"><joint name="b" axis="0 -1 0" damping="1e-3"/>{LINK}<site name="end" pos="0.04 0 0.005"/></body>',
            '<tendon><spatial name="cable"><site site="winch"/><geom geom="pulley" sidesite="side"/><site site="hole"/><pulley divisor="2"/><site site="start"/><site site="end"/></spatial>'
            '<spatial name="spring" stiffness="300" damping="2" springlength="0.07"><site site="post"/><site site="lug"/></spatial></tendon>'
            '<actuator><motor name="pull" tendon="cable" gear="2"/></actuator><keyframe><key qpos="0 0" ctrl="-1"/></keyframe>',
        ),
        scene(
            f'[bodies.a]\n{LINK_TOML}[bodies.b]\n{LINK_TOML}guess = {{ at = ["300 mm", "0 mm"] }}\n'
            '[joints.a]\nbodies = ["ground", "a"]\nat = ["0 mm", "0 mm"]\nstart = "0 rad"\ndamping = "1e-3 N*m*s/rad"\n'
            '[joints.b]\nbodies = ["ground", "b"]\nat = ["300 mm", "0 mm"]\nstart = "0 rad"\ndamping = "1e-3 N*m*s/rad"\n'
            '[tendons.c1]\npath = [{ eyelet = "ground", at = ["-40 mm", "20 mm"] }, { pulley = "ground", at = ["0 mm", "0 mm"], radius = "8 mm", turn = "ccw" }, { eyelet = "a", at = ["40 mm", "30 mm"] }]\n'
            '[tendons.c2]\npath = [{ eyelet = "ground", at = ["250 mm", "30 mm"] }, { eyelet = "b", at = ["40 mm", "5 mm"] }]\n'
            '[actuators.p1]\ntendon = "c1"\ntension = "2 N"\n[actuators.p2]\ntendon = "c2"\ntension = "1 N"\n'
            '[springs.s]\ntype = "linear"\nbodies = ["ground", "a"]\npoints = [["0 mm", "90 mm"], ["20 mm", "10 mm"]]\nstiffness = "300 N/m"\ndamping = "2 N*s/m"\nrest = "70 mm"\n'
        ),
        {"a": "a_rad", "b": "b_rad"},
    ),
    # A tendon equality with a0 and a second tendon; rates at the start.
    "tendon equality": Model(
        mjcf(
            "".join(
                f'<body name="{name}" pos="{x} 0 0"><joint name="{name}" axis="0 -1 0" ref="{ref}"/>{LINK}</body>'
                for name, x, ref in (("a", 0, 0.1), ("b", 0.2, 0), ("c", 0.4, 0.3))
            ),
            '<tendon><fixed name="t"><joint joint="a" coef="2"/><joint joint="b" coef="-1"/></fixed><fixed name="u"><joint joint="c" coef="0.5"/></fixed></tendon>'
            '<equality><tendon name="tie" tendon1="t" tendon2="u" polycoef="0.04 3 0 0 0"/></equality>'
            '<actuator><motor name="m" joint="c"/></actuator><keyframe><key qpos="0.1 -0.04 0.3" qvel="2 4 0" ctrl="0.02"/></keyframe>',
        ),
        # At the drawn position the tendons have the lengths 0.2 and 0.15: 2 a - b - 0.2 = 0.04 + 3 (0.5 c - 0.15).
        scene(
            "".join(
                f'[bodies.{name}]\n{LINK_TOML}guess = {{ at = ["{x} mm", "0 mm"], angle = "{turn} rad" }}\n[joints.{name}]\nbodies = ["ground", "{name}"]\n'
                f'points = [["{x} mm", "0 mm"], ["0 mm", "0 mm"]]\noffset = "{-ref} rad"\n{start}'
                for name, x, ref, turn, start in (
                    ("a", 0, 0.1, 0, 'start = "0.1 rad"\nstart_rate = "2 rad/s"\n'),
                    ("b", 200, 0, -0.04, ""),
                    ("c", 400, 0.3, 0, 'start = "0.3 rad"\nstart_rate = "0 rad/s"\n'),
                )
            )
            + '[couplings.tie]\njoints = ["a", "b", "c"]\nfactors = [2, -1, -1.5]\nvalue = "-0.21 rad"\n[actuators.m]\njoint = "c"\ntorque = "0.02 N*m"\n'
        ),
        {"a": "a_rad", "b": "b_rad", "c": "c_rad"},
    ),
}
