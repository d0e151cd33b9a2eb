#!/usr/bin/env python3
"""Writes the ROS 2 bags of the readers' tests, with the tables of rosbag2 and SQLite's own library.

Usage: make_db3.py MESSAGES.jsonl
MESSAGES.jsonl is what make_mcap.mjs writes: the messages as CDR.
"""
import json
import pathlib
import sqlite3
import sys

HERE = pathlib.Path(__file__).resolve().parent
TABLES = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
  data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema VALUES (3, 'humble');
"""


def write(path, messages, data="data"):
    path.unlink(missing_ok=True)
    database = sqlite3.connect(path)
    database.execute("PRAGMA page_size = 1024")
    database.executescript(TABLES)
    topics = {}
    for message in messages:
        if message["topic"] not in topics:
            topics[message["topic"]] = len(topics) + 1
            database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')",
                             (topics[message["topic"]], message["topic"], message["type"]))
        database.execute("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)",
                         (topics[message["topic"]], int(message["log"]), bytes.fromhex(message[data])))
    database.commit()
    database.close()


def metadata(folder, files, messages, storage="sqlite3", compression=("", "")):
    counts = {}
    for message in messages:
        counts[(message["topic"], message["type"])] = counts.get((message["topic"], message["type"]), 0) + 1
    topics = "".join(
        f"    - topic_metadata:\n        name: {name}\n        type: {kind}\n"
        f"        serialization_format: cdr\n        offered_qos_profiles: \"\"\n"
        f"      message_count: {count}\n" for (name, kind), count in counts.items())
    paths = "".join(f"    - {file}\n" for file in files)
    (folder / "metadata.yaml").write_text(
        f"rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: {storage}\n"
        f"  duration:\n    nanoseconds: 345000000\n"
        f"  starting_time:\n    nanoseconds_since_epoch: 1700000000000000000\n"
        f"  message_count: {len(messages)}\n  topics_with_message_count:\n{topics}"
        f"  compression_format: \"{compression[0]}\"\n  compression_mode: \"{compression[1]}\"\n"
        f"  relative_file_paths:\n{paths}", encoding="utf-8")


def main():
    messages = [json.loads(line) for line in open(sys.argv[1], encoding="utf-8")]
    write(HERE / "drive.db3", messages)
    split = HERE / "split_bag"
    split.mkdir(exist_ok=True)
    write(split / "split_0.db3", messages[:9])
    write(split / "split_1.db3", messages[9:])
    # As the first recorders wrote the names of files, with the folder.
    metadata(split, ["split_bag/split_0.db3", "split_bag/split_1.db3"], messages)
    packed = HERE / "packed_bag"
    packed.mkdir(exist_ok=True)
    write(packed / "packed_0.db3", messages, data="zstd")
    metadata(packed, ["packed_0.db3"], messages, compression=("zstd", "MESSAGE"))


if __name__ == "__main__":
    main()
