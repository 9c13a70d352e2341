#!/usr/bin/env python3
"""Shows a phalanx log in Rerun: bodies, contact points and forces in a view from above, every number as a plot.

Rerun opens a log by itself, but draws neither `foxglove.SceneUpdate` nor single fields of messages. This reads the log with
the public MCAP packages and hands Rerun what it draws: shapes once, then the transforms of their frames, arrows of the
forces, and one series a field, all on the timeline `time`.

    rerun_view.py LOG.mcap                     opens the viewer
    rerun_view.py LOG.mcap --save FILE.rrd     writes a recording instead
"""

import argparse
import sys
from pathlib import Path

try:
    import numpy
    import rerun
    import rerun.blueprint as blueprint
    from mcap.exceptions import McapError
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory
except ImportError as error:
    sys.exit(f"{error}; install what it needs: pip install -r {Path(__file__).with_name('requirements.txt')}")

TIMELINE = "time"

# Thickness of outlines and arrows and size of contact points, in m.
OUTLINE_M = 1e-4
ARROW_M = 2.5e-4
POINT_M = 6e-4


def read(path):
    """Every message of a log by topic: lists of (time in ns, message)."""
    topics = {}
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, body in reader.iter_decoded_messages(log_time_order=False):
            topics.setdefault(channel.topic, []).append((message.log_time, body))
    return topics


def timeline(times_ns):
    """The index column of some rows."""
    return [rerun.TimeColumn(TIMELINE, duration=numpy.array(times_ns, dtype="timedelta64[ns]"))]


def vector(of):
    return [of.x, of.y, of.z]


def turned(orientation, along):
    """A direction in the plane, turned by a quaternion about z."""
    cosine = orientation.w**2 - orientation.z**2
    sine = 2.0 * orientation.w * orientation.z
    return [cosine * along, sine * along, 0.0]


def rgba(colour):
    return [round(255 * part) for part in (colour.r, colour.g, colour.b, colour.a)]


def shapes(entities):
    """Outlines and areas of the bodies, each under the transform of its frame."""
    for entity in entities:
        path = f"/world/{entity.frame_id}"
        outlines = [[vector(point) for point in [*line.points, line.points[0]]] for line in entity.lines]
        colours = [rgba(line.color) for line in entity.lines]
        if outlines:
            rerun.log(f"{path}/outline", rerun.LineStrips3D(outlines, colors=colours, radii=OUTLINE_M), static=True)
        for number, area in enumerate(entity.triangles):
            points = [vector(point) for point in area.points]
            indices = numpy.array(area.indices, dtype="uint32").reshape(-1, 3)
            mesh = rerun.Mesh3D(
                vertex_positions=points, triangle_indices=indices, vertex_colors=[rgba(area.color)] * len(points)
            )
            rerun.log(f"{path}/area_{number}", mesh, static=True)


def transforms(messages):
    """Where the frames are; all of them hang from `world`."""
    rows = {}
    for time_ns, body in messages:
        for frame in body.transforms:
            turn = frame.rotation
            row = (time_ns, vector(frame.translation), [turn.x, turn.y, turn.z, turn.w])
            rows.setdefault(frame.child_frame_id, []).append(row)
    for name, found in rows.items():
        times_ns, places, turns = zip(*found)
        columns = rerun.Transform3D.columns(translation=places, quaternion=turns)
        rerun.send_columns(f"/world/{name}", timeline(times_ns), columns)


def forces(messages):
    """Arrows and contact points; a contact without any is empty from there on."""
    for time_ns, body in messages:
        rerun.set_time(TIMELINE, duration=numpy.timedelta64(time_ns, "ns"))
        for entity in body.entities:
            origins = [vector(arrow.pose.position) for arrow in entity.arrows]
            lengths = [arrow.shaft_length + arrow.head_length for arrow in entity.arrows]
            vectors = [turned(arrow.pose.orientation, length) for arrow, length in zip(entity.arrows, lengths)]
            colours = [rgba(arrow.color) for arrow in entity.arrows]
            arrows = rerun.Arrows3D(origins=origins, vectors=vectors, colors=colours, radii=ARROW_M)
            rerun.log(f"/world/forces/{entity.id}/arrows", arrows)
            points = [vector(sphere.pose.position) for sphere in entity.spheres]
            colours = [rgba(sphere.color) for sphere in entity.spheres]
            rerun.log(f"/world/forces/{entity.id}/point", rerun.Points3D(points, colors=colours, radii=POINT_M))


def numbers(topic, messages):
    """One series for every double of a topic."""
    times_ns = [time_ns for time_ns, _ in messages]
    for field in messages[0][1].DESCRIPTOR.fields:
        if field.name == "timestamp" or field.cpp_type != field.CPPTYPE_DOUBLE:
            continue
        values = [getattr(body, field.name) for _, body in messages]
        rerun.send_columns(f"{topic}/{field.name}", timeline(times_ns), rerun.Scalars.columns(scalars=values))


def events(topic, messages):
    """Lines of text."""
    times_ns = [time_ns for time_ns, _ in messages]
    levels = ["ERROR" if body.level >= 4 else "INFO" for _, body in messages]
    columns = rerun.TextLog.columns(text=[body.message for _, body in messages], level=levels)
    rerun.send_columns(topic, timeline(times_ns), columns)


def plots(topics):
    """Names and contents of the plots: (name, entities)."""
    contacts = [topic for topic in topics if topic.startswith("/contact/")]
    discs = [topic for topic in topics if topic.startswith("/disc/")]
    wanted = [
        ("angles (rad)", [f"/state/{name}_rad" for name in ("q11", "q21", "q22")] if "/state" in topics else []),
        ("places (m)", [f"{disc}/{axis}_m" for disc in discs for axis in "xy"]),
        ("gaps (m)", [f"{contact}/gap_m" for contact in contacts]),
        ("normal forces (N)", [f"{contact}/normal_n" for contact in contacts]),
        ("tangential forces (N)", [f"{contact}/tangential_n" for contact in contacts]),
        ("energies (J)", [f"/energy/{name}_j" for name in ("kinetic", "spring", "elastic", "dissipated", "motor_work")]),
    ]
    return [(name, entities) for name, entities in wanted if entities]


def arrangement(topics):
    """The view from above beside the plots, the events below."""
    corners = [point for _, body in topics.get("/scene", []) for entity in body.entities
               for line in entity.lines if line.points for point in line.points if entity.id != "palm"]
    reach = max((max(abs(point.x), abs(point.y)) for point in corners), default=0.05)
    eye = blueprint.EyeControls3D(
        position=[0.0, 0.5 * reach, 4.0 * reach], look_target=[0.0, 0.5 * reach, 0.0], eye_up=[0.0, 1.0, 0.0]
    )
    above = blueprint.Spatial3DView(origin="/world", name="from above", eye_controls=eye, line_grid=False)
    series = [blueprint.TimeSeriesView(name=name, contents=entities) for name, entities in plots(topics)]
    below = blueprint.TextLogView(origin="/events", name="events")
    picture = blueprint.Vertical(above, below, row_shares=[4, 1])
    return blueprint.Blueprint(
        blueprint.Horizontal(picture, blueprint.Vertical(*series), column_shares=[1, 1]),
        blueprint.TimePanel(timeline=TIMELINE, playback_speed=1e-3),
        collapse_panels=True,
    )


def show(topics):
    """Hands everything to the recording that has been begun."""
    for topic, messages in topics.items():
        kind = messages[0][1].DESCRIPTOR.full_name
        if kind == "foxglove.FrameTransforms":
            transforms(messages)
        elif kind == "foxglove.SceneUpdate" and topic == "/scene":
            shapes(messages[0][1].entities)
        elif kind == "foxglove.SceneUpdate":
            forces(messages)
        elif kind == "foxglove.Log":
            events(topic, messages)
        else:
            numbers(topic, messages)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("log", metavar="LOG.mcap", type=Path, help="a log of `phalanx run --log`")
    parser.add_argument("--save", metavar="FILE.rrd", type=Path, help="write a recording instead of opening the viewer")
    arguments = parser.parse_args()
    try:
        topics = read(arguments.log)
    except (OSError, McapError) as error:
        sys.exit(f"cannot read {arguments.log}: {error or type(error).__name__}; give the log of a finished run")
    if not topics:
        sys.exit(f"{arguments.log} has no messages; give the log of a finished run")
    plan = arrangement(topics)
    rerun.init("phalanx", recording_id=arguments.log.stem, default_blueprint=plan)
    if arguments.save:
        rerun.save(arguments.save, default_blueprint=plan)
    else:
        rerun.spawn(default_blueprint=plan)
    show(topics)


if __name__ == "__main__":
    main()
