#!/usr/bin/env python3
"""Shows a phalanx log in Rerun: bodies, contact points and forces in a view from above, and every number as a plot.

Rerun can open a log itself, but draws neither `foxglove.SceneUpdate` nor single fields of messages. This script reads
the log with the public MCAP packages and sends to Rerun the shapes (once), the transforms of their frames, force
arrows, and one series per field, all on the timeline `time`.

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
    sys.exit(f"{error}; install the requirements: pip install -r {Path(__file__).with_name('requirements.txt')}")

TIMELINE = "time"

# Thickness of outlines and arrows and size of contact points, in m.
OUTLINE_M = 1e-4
ARROW_M = 2.5e-4
POINT_M = 6e-4


def read(path):
    """Returns all messages of a log by topic, as lists of (time in ns, message)."""
    topics = {}
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, body in reader.iter_decoded_messages(log_time_order=False):
            topics.setdefault(channel.topic, []).append((message.log_time, body))
    return topics


def timeline(times_ns):
    """Returns the time column of rows."""
    return [rerun.TimeColumn(TIMELINE, duration=numpy.array(times_ns, dtype="timedelta64[ns]"))]


def vector(message):
    """Returns the components of a vector or point."""
    return [message.x, message.y, message.z]


def rotated_x(orientation, length):
    """Returns a vector of the given length along x, rotated by a quaternion about z."""
    cosine = orientation.w**2 - orientation.z**2
    sine = 2.0 * orientation.w * orientation.z
    return [cosine * length, sine * length, 0.0]


def rgba(colour):
    """Returns a colour with 8-bit components."""
    return [round(255 * component) for component in (colour.r, colour.g, colour.b, colour.a)]


def send_shapes(entities):
    """Sends the outlines and areas of the bodies, each in its frame."""
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


def send_transforms(messages):
    """Sends the poses of the frames relative to `world`."""
    rows_by_frame = {}
    for time_ns, body in messages:
        for frame in body.transforms:
            rotation = frame.rotation
            row = (time_ns, vector(frame.translation), [rotation.x, rotation.y, rotation.z, rotation.w])
            rows_by_frame.setdefault(frame.child_frame_id, []).append(row)
    for name, rows in rows_by_frame.items():
        times_ns, translations, quaternions = zip(*rows)
        columns = rerun.Transform3D.columns(translation=translations, quaternion=quaternions)
        rerun.send_columns(f"/world/{name}", timeline(times_ns), columns)


def send_forces(messages):
    """Sends force arrows and contact points; empty lists clear those of an inactive contact."""
    for time_ns, body in messages:
        rerun.set_time(TIMELINE, duration=numpy.timedelta64(time_ns, "ns"))
        for entity in body.entities:
            origins = [vector(arrow.pose.position) for arrow in entity.arrows]
            lengths = [arrow.shaft_length + arrow.head_length for arrow in entity.arrows]
            vectors = [rotated_x(arrow.pose.orientation, length) for arrow, length in zip(entity.arrows, lengths)]
            colours = [rgba(arrow.color) for arrow in entity.arrows]
            arrows = rerun.Arrows3D(origins=origins, vectors=vectors, colors=colours, radii=ARROW_M)
            rerun.log(f"/world/forces/{entity.id}/arrows", arrows)
            points = [vector(sphere.pose.position) for sphere in entity.spheres]
            colours = [rgba(sphere.color) for sphere in entity.spheres]
            rerun.log(f"/world/forces/{entity.id}/point", rerun.Points3D(points, colors=colours, radii=POINT_M))


def send_numbers(topic, messages):
    """Sends one series for every field of type double of a topic."""
    times_ns = [time_ns for time_ns, _ in messages]
    for field in messages[0][1].DESCRIPTOR.fields:
        if field.name == "timestamp" or field.cpp_type != field.CPPTYPE_DOUBLE:
            continue
        values = [getattr(body, field.name) for _, body in messages]
        rerun.send_columns(f"{topic}/{field.name}", timeline(times_ns), rerun.Scalars.columns(scalars=values))


def send_events(topic, messages):
    """Sends log messages as text lines."""
    times_ns = [time_ns for time_ns, _ in messages]
    levels = ["ERROR" if body.level >= 4 else "INFO" for _, body in messages]
    columns = rerun.TextLog.columns(text=[body.message for _, body in messages], level=levels)
    rerun.send_columns(topic, timeline(times_ns), columns)


def plots(topics):
    """Returns the plots with content: (name, entities)."""
    contacts = [topic for topic in topics if topic.startswith("/contact/") and not topic.endswith("limit")]
    bodies = [topic for topic in topics if topic.startswith("/body/")]
    joints = [topic for topic in topics if topic.startswith("/joint/") and not topic.endswith(("q12", "loop"))]
    all_plots = [
        ("angles (rad)", [f"{joint}/angle_rad" for joint in joints]),
        ("positions (m)", [f"{body}/{axis}_m" for body in bodies for axis in "xy"]),
        ("gaps (m)", [f"{contact}/gap_m" for contact in contacts]),
        ("normal forces (N)", [f"{contact}/normal_n" for contact in contacts]),
        ("tangential forces (N)", [f"{contact}/tangential_n" for contact in contacts]),
        ("energies (J)", [f"/energy/{name}_j" for name in ("kinetic", "spring", "elastic", "dissipated", "motor_work")]),
    ]
    return [(name, entities) for name, entities in all_plots if entities]


def build_blueprint(topics):
    """Returns the layout: the view from above with the events below it on the left, the plots on the right."""
    corners = [point for _, body in topics.get("/scene", []) for entity in body.entities
               for line in entity.lines if line.points for point in line.points if entity.id != "palm"]
    size = max((max(abs(point.x), abs(point.y)) for point in corners), default=0.05)
    eye = blueprint.EyeControls3D(
        position=[0.0, 0.5 * size, 4.0 * size], look_target=[0.0, 0.5 * size, 0.0], eye_up=[0.0, 1.0, 0.0]
    )
    spatial_view = blueprint.Spatial3DView(origin="/world", name="from above", eye_controls=eye, line_grid=False)
    series = [blueprint.TimeSeriesView(name=name, contents=entities) for name, entities in plots(topics)]
    event_view = blueprint.TextLogView(origin="/events", name="events")
    left = blueprint.Vertical(spatial_view, event_view, row_shares=[4, 1])
    return blueprint.Blueprint(
        blueprint.Horizontal(left, blueprint.Vertical(*series), column_shares=[1, 1]),
        blueprint.TimePanel(timeline=TIMELINE, playback_speed=1e-3),
        collapse_panels=True,
    )


def send(topics):
    """Sends all topics to the current recording."""
    for topic, messages in topics.items():
        message_type = messages[0][1].DESCRIPTOR.full_name
        if message_type == "foxglove.FrameTransforms":
            send_transforms(messages)
        elif message_type == "foxglove.SceneUpdate" and topic == "/scene":
            send_shapes(messages[0][1].entities)
        elif message_type == "foxglove.SceneUpdate":
            send_forces(messages)
        elif message_type == "foxglove.Log":
            send_events(topic, messages)
        else:
            send_numbers(topic, messages)


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
    layout = build_blueprint(topics)
    rerun.init("phalanx", recording_id=arguments.log.stem, default_blueprint=layout)
    if arguments.save:
        rerun.save(arguments.save, default_blueprint=layout)
    else:
        rerun.spawn(default_blueprint=layout)
    send(topics)


if __name__ == "__main__":
    main()
