"""Reads a bag with Debian's python3-rosbag, every message deserialised, and prints what it found as JSON.

Usage: read_bag.py BAG. Warnings are errors: whatever rosbag complains about ends this with a traceback.
"""
import json
import sys
import warnings

warnings.simplefilter("error")
import rosbag  # noqa: E402

topics = {}
with rosbag.Bag(sys.argv[1]) as bag:
    info = bag.get_type_and_topic_info().topics
    for topic, message, time in bag.read_messages():
        entry = topics.setdefault(topic, {"count": 0, "points": 0, "first": time.to_nsec(), "last": 0})
        entry["count"] += 1
        entry["last"] = time.to_nsec()
        entry["type"] = message._type
        entry["md5"] = message._md5sum
        if hasattr(message, "point_num"):
            assert message.point_num == len(message.points)
            entry["points"] += message.point_num
        elif hasattr(message, "point_step"):
            assert len(message.data) == message.row_step * message.height
            assert message.row_step == message.point_step * message.width
            entry["points"] += message.width * message.height
            entry["fields"] = [field.name for field in message.fields]
    compression = bag.get_compression_info().compression
    for topic, entry in topics.items():
        assert info[topic].message_count == entry["count"], topic
        assert info[topic].msg_type == entry["type"], topic
print(json.dumps({"topics": topics, "compression": compression}, sort_keys=True))
