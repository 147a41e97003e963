#!/usr/bin/env python3
"""Makes the corpora of the fuzz targets: small valid inputs, and a few that are wrong in one way.

usage: make_corpus.py [FOLDER]     (default: corpus/ beside this script)

Files that findings have left (named `found_*`) are not of this script. The configurations in configs/ are read as they are.
"""
import bz2
import json
import math
import pathlib
import struct
import sys
import zlib

HERE = pathlib.Path(__file__).resolve().parent
START = 1_600_000_000
LIVOX = ("livox_ros_driver/CustomMsg", "e4d6829bdfe657cb6c21a746c86b21a6")
IMU = ("sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2")
CLOUD = ("sensor_msgs/PointCloud2", "1158d486dd51d683ce2f1be655c3c181")


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def stamp(nanoseconds):
    return struct.pack("<II", START + nanoseconds // 10**9, nanoseconds % 10**9)


def header(nanoseconds):
    return struct.pack("<I", 7) + stamp(nanoseconds) + text("frame")


def imu(nanoseconds, acc=9.8):
    zeros = [0.0] * 9
    values = [0.0, 0.0, 0.0, 1.0] + zeros + [0.01, 0.0, 0.0] + zeros + [0.0, 0.0, acc] + zeros
    return header(nanoseconds) + struct.pack("<37d", *values)


def livox(nanoseconds, points=12):
    out = header(nanoseconds) + struct.pack("<QIB3xI", START * 10**9 + nanoseconds, points, 0, points)
    for i in range(points):
        out += struct.pack("<Ifff3B", 99_000_000 * i // max(points - 1, 1), 5.0 + i, 1.0, -0.5, i, 0x10, i % 4)
    return out


def cloud(nanoseconds, time_name, kind, unit, absolute=False, points=12, line="ring"):
    """`kind`: datatype of the time; `unit`: seconds in one of it."""
    codes = {6: "I", 7: "f", 8: "d"}
    fields = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7), (line, 16, 2), ("tag", 17, 2)]
    fields += [(time_name, 20, kind)] if time_name else []
    step = 28
    out = header(nanoseconds) + struct.pack("<III", 1, points, len(fields))
    for name, offset, datatype in fields:
        out += text(name) + struct.pack("<IBI", offset, datatype, 1)
    data = b""
    for i in range(points):
        seconds = 0.099 * i / (points - 1) + (START + nanoseconds * 1e-9 if absolute else 0)
        value = seconds / unit if kind >= 7 else round(seconds / unit)
        point = struct.pack("<ffffBBxx", 5.0 + i, 1.0, -0.5, i, i % 4, 0x10) + struct.pack("<" + codes.get(kind, "f"), value)
        data += point.ljust(step, b"\0")
    return out + struct.pack("<BII", 0, step, step * points) + struct.pack("<I", len(data)) + data + b"\1"


def record(fields, data):
    out = b""
    for name, value in fields:
        field = name.encode() + b"=" + value
        out += struct.pack("<I", len(field)) + field
    return struct.pack("<I", len(out)) + out + struct.pack("<I", len(data)) + data


def xxh32(data):
    """Of fewer than 16 bytes, as frames of lz4 need it."""
    mask, primes = 0xFFFFFFFF, (2654435761, 2246822519, 3266489917, 668265263, 374761393)
    h = (primes[4] + len(data)) & mask
    for byte in data:
        h = (h + byte * primes[4]) & mask
        h = ((h << 11 | h >> 21) * primes[0]) & mask
    h = ((h ^ h >> 15) * primes[1]) & mask
    h = ((h ^ h >> 13) * primes[2]) & mask
    return h ^ h >> 16


def lz4(data):
    """A frame of one block that is stored as it is."""
    descriptor = bytes([0x60, 0x40])
    return (struct.pack("<I", 0x184D2204) + descriptor + bytes([xxh32(descriptor) >> 8 & 255]) +
            struct.pack("<I", len(data) | 1 << 31) + data + struct.pack("<I", 0))


def bag(messages, types, compression="none", index=True):
    """`messages`: (connection, nanoseconds, bytes), two chunks of them; `types`: (topic, name, md5) by connection."""
    u8, u32, u64 = (lambda v: struct.pack("<B", v)), (lambda v: struct.pack("<I", v)), (lambda v: struct.pack("<Q", v))

    def connection(number):
        topic, name, md5 = types[number]
        fields = [("topic", topic.encode()), ("type", name.encode()), ("md5sum", md5.encode()),
                  ("message_definition", b"x")]
        data = b"".join(struct.pack("<I", len(n) + 1 + len(v)) + n.encode() + b"=" + v for n, v in fields)
        return record([("op", u8(7)), ("conn", u32(number)), ("topic", topic.encode())], data)

    def bag_header(position, chunks):
        return record([("op", u8(3)), ("index_pos", u64(position)), ("conn_count", u32(len(types))),
                       ("chunk_count", u32(chunks))], b" " * 16)

    magic, body, infos = b"#ROSBAG V2.0\n", b"", b""
    begin = len(magic) + len(bag_header(0, 0))
    halves = [messages[:len(messages) // 2], messages[len(messages) // 2:]]
    for k, part in enumerate(halves):
        inside = b"".join(connection(i) for i in range(len(types))) if k == 0 else b""
        entries = {}
        for number, t, data in part:
            entries.setdefault(number, []).append((t, len(inside)))
            inside += record([("op", u8(2)), ("conn", u32(number)), ("time", stamp(t))], data)
        packed = {"none": lambda d: d, "bz2": bz2.compress, "lz4": lz4}[compression](inside)
        position = begin + len(body)
        body += record([("op", u8(5)), ("compression", compression.encode()), ("size", u32(len(inside)))], packed)
        for number, times in entries.items():
            body += record([("op", u8(4)), ("ver", u32(1)), ("conn", u32(number)), ("count", u32(len(times)))],
                           b"".join(stamp(t) + u32(at) for t, at in times))
        times = [t for _, t, _ in part]
        infos += record([("op", u8(6)), ("ver", u32(1)), ("chunk_pos", u64(position)), ("start_time", stamp(min(times))),
                         ("end_time", stamp(max(times))), ("count", u32(len(entries)))],
                        b"".join(u32(n) + u32(len(t)) for n, t in entries.items()))
    if not index:
        return magic + bag_header(0, 0) + body
    ends = b"".join(connection(i) for i in range(len(types))) + infos
    return magic + bag_header(begin + len(body), len(halves)) + body + ends


def zstd(data):
    """A frame of one block that is stored as it is."""
    return struct.pack("<IBI", 0xFD2FB528, 0xA0, len(data)) + (len(data) << 3 | 1).to_bytes(3, "little") + data


def mcap(messages, channels, compression="", chunks=True, index=True, crc=True):
    """`messages`: (channel, nanoseconds, bytes), two chunks of them; `channels`: (topic, schema, encoding)."""
    def op(kind, *content):
        content = b"".join(content)
        return struct.pack("<BQ", kind, len(content)) + content

    def summed(data):
        return struct.pack("<I", zlib.crc32(data) if crc else 0)

    sized = lambda data: struct.pack("<I", len(data)) + data
    schemas = b"".join(op(3, struct.pack("<H", i), text(name), text("ros1msg"), text("x"))
                       for i, name in enumerate(sorted({name for _, name, _ in channels}), 1))
    names = sorted({name for _, name, _ in channels})
    described = schemas + b"".join(
        op(4, struct.pack("<HH", i, names.index(name) + 1), text(topic), text(encoding), sized(text("md5sum") + text("0")))
        for i, (topic, name, encoding) in enumerate(channels))
    magic = b"\x89MCAP0\r\n"
    out = magic + op(1, text("ros1"), text("")) + (b"" if chunks else described)
    indexes = b""
    for k, part in enumerate((messages[:len(messages) // 2], messages[len(messages) // 2:])):
        inside, entries = described if k == 0 and chunks else b"", {}
        for number, t, data in part:
            entries.setdefault(number, []).append(struct.pack("<QQ", t, len(inside)))
            inside += op(5, struct.pack("<HIQQ", number, 0, t, t), data)
        if not chunks:
            out += inside
            continue
        packed = {"": lambda d: d, "lz4": lz4, "zstd": zstd}[compression](inside)
        span = struct.pack("<QQ", min(t for _, t, _ in part), max(t for _, t, _ in part))
        chunk = op(6, span, struct.pack("<Q", len(inside)), summed(inside), text(compression), struct.pack("<Q", len(packed)), packed)
        at, places, behind = len(out), b"", b""
        for number, times in entries.items():
            places += struct.pack("<HQ", number, at + len(chunk) + len(behind))
            behind += op(7, struct.pack("<H", number), sized(b"".join(times)))
        indexes += op(8, span, struct.pack("<QQ", at, len(chunk)), sized(places), struct.pack("<Q", len(behind)),
                      text(compression), struct.pack("<QQ", len(packed), len(inside)))
        out += chunk + behind
    out += op(9, struct.pack("<QQ", 0, 0), text("name"), text("text/plain"), struct.pack("<QI", 0, 0))
    out += op(15, summed(out))
    counts = b"".join(struct.pack("<HQ", i, sum(number == i for number, _, _ in messages)) for i in range(len(channels)))
    statistics = op(11, struct.pack("<QHIIIIQQ", len(messages), len(names), len(channels), 1, 0, 2 * chunks, 0, 0), sized(counts))
    summary = described + indexes + statistics if index else b""
    footer = struct.pack("<BQQQ", 2, 20, len(out) if index else 0, 0)
    return out + summary + footer + summed(summary + footer) + magic


def recording(lidar, sweep, samples=4, **options):
    messages = [(0, i * 10**8 // 2, imu(i * 10**8 // 2)) for i in range(samples)]
    messages += [(1, i * 10**8 + 1, sweep(i * 10**8)) for i in range(2)]
    messages.sort(key=lambda m: m[1])
    return bag(messages, [("/imu", *IMU), ("/lidar", *lidar)], **options)


def elf(segments=2, bytes_behind=64):
    """As much of a shared object as is looked at before it is loaded."""
    size = 64 + 56 * segments + bytes_behind
    out = b"\x7fELF" + bytes([2, 1, 1]) + bytes(9)
    out += struct.pack("<HHIQQQIHHHHHH", 3, 62, 1, 0, 64, size - 64, 0, 64, 56, segments, 64, 1, 0)
    for i in range(segments):
        out += struct.pack("<IIQQQQQQ", 1 + i % 2, 5, 0, 0, 0, size, size, 0x1000)
    return out + bytes(bytes_behind)


def files(**named):
    """One input of several files: `a__b_c` stands for a/b.c."""
    out = b""
    for name, content in named.items():
        content = content if isinstance(content, bytes) else content.encode()
        stem, _, ending = name.replace("__", "/").rpartition("_")
        out += f"=== {stem}.{ending}\n".encode() + content + (b"" if content.endswith(b"\n") else b"\n")
    return out


def tum(rate, count, turn=0.1):
    lines = []
    for i in range(count):
        t, yaw = i / rate, turn * i
        lines.append(f"{START + t:.9f} {math.cos(yaw):.6f} {math.sin(yaw):.6f} 1.4 0 0 {math.sin(yaw / 2):.9f} {math.cos(yaw / 2):.9f}")
    return "\n".join(lines) + "\n"


def updates(count):
    lines = ["t_ns,status,sod,iterations,n_matches,eig_1,residual_rms_m,tracking,gyro_rms_rad_s"]
    for i in range(count):
        lines.append(f"{START * 10**9 + i * 10**8},{'ok' if i % 5 else 'degenerate'},{0.8 if i else ''},2,{900 + i},50,0.02,ok,0.1")
    return "\n".join(lines) + "\n"


HOSTILE = "</script><script>f()</script><!-- ]]> \u2028 &amp; \" ' end"
SENSOR = (HERE.parents[1] / "configs/sensors/livox_avia.yaml")
RESULTS = "data,sequence,seed,order_seed,method,status,reason,ate_m,ate_deg,rate_hz\n"


def report_inputs():
    ply = ("ply\nformat binary_little_endian 1.0\nelement vertex 3\n" +
           "".join(f"property float {n}\n" for n in ("x", "y", "z", "intensity")) + "end_header\n").encode()
    ply += struct.pack("<12f", *(0.5 * i for i in range(12)))
    summary = json.dumps({"status": "ok", "initialisation": "static start", "notes": ["imu rate: 200 Hz"],
                          "metrics": {"ate_m": 0.02}, "rate_hz": {"median": 10.0}, "cpu_s": 1, "data_s": 20,
                          "calibration": {"text": "IMU delay 2 ms"}})
    manifest = json.dumps({"aslio": "0.1.0", "build": {"flags": "-O2"}, "input": {"path": "a.bag"}})
    study = json.dumps({"schema": "aslio/study_results/1", "name": "small", "question": "Which?", "prediction": "b.", "rule": "Lower.",
                        "planned": 2, "done": 1, "metrics": ["ate_m"],
                        "methods": [{"name": "b", "label": "B", "baseline": "c", "differs": ["map"]}],
                        "expectation": {"overall": "holds", "rules": [{"text": "it pays", "verdict": "holds", "open": ""}]},
                        "identical": ["b and c"]})
    statistics = ("metric,sequence,method,baseline,low,high,effect,p,p_holm,p_sequences\n"
                  "ate_m,,b,c,0.4,inf,-0.5,0.0004,0.125,0.25\n")
    run = {"runs__a__b__summary_json": summary, "runs__a__b__manifest_json": manifest,
           "runs__a__b__updates_csv": updates(12), "runs__a__b__trajectory_tum": tum(10, 12)}
    yield "study", files(results_csv=RESULTS + "a,a,1,0,b,ok,,0.05,0.2,10\na,a,1,0,c,diverged,far off,9,1,10\n",
                         study_json=study, statistics_csv=statistics, verdict_md="# Verdict\n\n- **holds**\n", **run)
    yield "course", files(results_csv=RESULTS + "a,a,1,0,b,ok,,0.05,0.2,10\n", data__a__truth_tum=tum(20, 24, 0.05),
                          data__a__overlap_csv="t,static_rays,true_overlap\n1600000000.1,9,0.5\n1600000001.0,9,0.9\n",
                          runs__a__b__timings_csv=f"t_ns,predict_s,solve_s\n{START}000000000,1e-4,5e-4\n",
                          runs__a__b__resolved_yaml="window: {type: fixed}\n", runs__a__b__map_ply=ply, **run)
    yield "hostile", files(results_csv=RESULTS + f'{"a"},"{HOSTILE.replace(chr(34), chr(34) * 2)}",1,0,b,failed,=cmd(),,,\n',
                           study_json=json.dumps({"schema": "aslio/study_results/1", "name": HOSTILE, "question": HOSTILE}), verdict_md=HOSTILE,
                           runs__a__b__summary_json=json.dumps({"status": "failed", "notes": [HOSTILE]}))
    yield "single", files(summary_json=summary)


def outcome_inputs():
    sensor = SENSOR.read_text(encoding="utf-8")
    matrix, sigma = [0.001 * i for i in range(9)], [0.0001] * 9
    calibrated = {"status": "ok", "reason": "", "metrics": {"ate_m": 0.01},
                  "calibration": {"gyro_sensitivity": matrix, "gyro_sensitivity_sigma": sigma, "imu_delay_s": 0.002,
                                  "imu_delay_sigma_s": 0.0001}}
    yield "calibration", files(summary_json=json.dumps(calibrated),
                               manifest_json=json.dumps({"sensor": {"resolved": sensor}, "input": {"sha256": "ab"}}))
    key = json.dumps({"key": "k", "status": "ok", "reason": "", "wall_s": 1.5, "final": True, "limit": 0})
    yield "status", files(plan_csv="data,sequence,run,method,identity,key,jobs\na,a,b,b,1,k,2\na,a,c,c,1,l,2\n",
                          runs__a__b__run_key_json=key, runs__a__b__summary_json=json.dumps(calibrated))
    yield "outcome", files(run_key_json=key, summary_json=json.dumps(
        {"status": "ok", "metrics": {"ate_m": 1e-2, "error": None}, "coverage": 0.99, "updates": 100, "cpu_s": 2,
         "data_s": 10, "rate_hz": {"median": 10}}))


def study_inputs():
    head = "schema: aslio/study/1\nquestion: Which?\nprediction: This.\nrule: Lower.\n"
    pipeline = (HERE.parents[1] / "configs/pipelines/kiss_icp.yaml").read_text(encoding="utf-8")
    pipeline = "".join(line for line in pipeline.splitlines(True) if not line.startswith("#"))
    method = "methods:\n  - {name: a, pipeline: pipeline.yaml}\n"
    yield "grid", files(study_yaml=head + "datasets:\n  - {scene: scene.yaml, seeds: 1-3}\n" + method +
                        "  - {name: b, pipeline: pipeline.yaml, set: {window.period: 0.05}, differs: [window]}\n"
                        "vary:\n  - {path: map.voxel, values: [0.5, 1.0]}\nbaseline: a\norder_seeds: [0, 1]\n"
                        "expectation:\n  - {claim: better, method: b, against: a, lower_on: 3 of 3 pairs}\n",
                        pipeline_yaml=pipeline, scene_yaml="x\n")
    yield "list", files(study_yaml=head + "datasets:\n  - {scene: scene.yaml, seeds: '1,3', set: [walk.speed={seed}], name: s}\n"
                        + method + "vary:\n  - {name: variant, list: [{name: u, set: {map.voxel: 0.5}}, {name: v, set: {}}]}\n"
                        "  - {zip: {map.radius: [50, 60], window.period: [0.1, 0.2]}}\nmetrics: [ate_m]\n",
                        pipeline_yaml=pipeline, scene_yaml="x\n")
    yield "recording", files(study_yaml=head + "datasets:\n  - {dataset: dataset.yaml}\n" + method, pipeline_yaml=pipeline,
                             dataset_yaml="schema: aslio/dataset/1\nname: d\ninput: data.bag\nsensor: sensor.yaml\n"
                             "reference: truth.tum\nstart: 1\nduration: 2\n", data_bag="x", sensor_yaml="x", truth_tum="x")


def kitti_inputs():
    times = [f"2011-09-26 13:04:32.{i:09d}" for i in (0, 10**8, 2 * 10**8)]
    packet = " ".join("9.8" if i == 13 else f"{0.01 * i:.2f}" for i in range(30)) + "\n"
    scan = struct.pack("<16f", 5, 0, 0, 0.1, 0, 5, 0, 0.2, -5, -1e-6, 0, 0.3, 0, -5, 0, 0.4)
    both = {"velodyne_points__timestamps_start_txt": "\n".join(times[:2]) + "\n",
            "velodyne_points__timestamps_end_txt": "\n".join(times[1:]) + "\n",
            "oxts__timestamps_txt": "\n".join(times[:2]) + "\n",
            "oxts__data__0000000000_txt": packet, "oxts__data__0000000001_txt": packet}
    yield "drive", files(calib_imu_to_velo_txt="R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.7\n",
                         velodyne_points__data__0000000000_bin=scan, **both)


def velodyne(product=0x22, mode=0x37, banks=1):
    blocks = b"".join(struct.pack("<HH", 0xEEFF - 0x1100 * (b % banks), 40 * b) + struct.pack("<HB", 5000, 7) * 32
                      for b in range(12))
    return blocks + struct.pack("<IBB", 1000, mode, product)


def hesai(channels=16, blocks=8):
    body = b"".join(struct.pack("<H", 18 * b) + struct.pack("<HBB", 2500, 9, 0) * channels for b in range(blocks))
    head = struct.pack("<HBBHBBBBBB", 0xFFEE, 6, 1, 0, channels, blocks, 0, 4, 1, 1)
    return head + body + bytes(10) + struct.pack("<BHBBBBBBIBI", 0x37, 600, 120, 9, 13, 12, 26, 40, 100, 0x42, 5)


def ouster(rows=2, columns=4):
    """Metadata and a packet of profile LEGACY."""
    metadata = json.dumps({"beam_altitude_angles": [1.5] * rows, "beam_azimuth_angles": [0.5] * rows, "lidar_mode": "512x10",
                           "data_format": {"columns_per_packet": columns, "columns_per_frame": 512},
                           "lidar_origin_to_beam_origin_mm": 15.8, "prod_line": "OS-1"})
    packet = b"".join(struct.pack("<QHHI", 10**9 + 10**5 * c, c, 3, 0) + struct.pack("<IHHHH", 5000, 5, 5, 5, 0) * rows +
                      b"\xff" * 4 for c in range(columns))
    return metadata.encode() + b"\0" + packet


def scan(packets, width=None, cdr=False):
    """`width`: of a packet's field; nothing where that is its own length."""
    out = struct.pack("<BBBBIII", 0, 1, 0, 0, START, 0, 4) + b"lid\0" if cdr else header(0)
    out += struct.pack("<I", len(packets))
    for i, packet in enumerate(packets):
        out += bytes(-len(out) % 4 if cdr else 0) + stamp(10**6 * i)
        out += packet if width is None else packet.ljust(width, b"\0")
        out += b"" if width is None else bytes(-len(out) % 4 if cdr else 0) + struct.pack("<I", len(packet))
    return out


def capture(packets, fragment=None):
    out = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)
    for i, packet in enumerate(packets):
        udp = struct.pack(">HHHH", 2368, 2368, 8 + len(packet), 0) + packet
        step = fragment or len(udp)
        for at in range(0, len(udp), step):
            part = udp[at:at + step]
            flags = (0x2000 if at + step < len(udp) else 0) | at // 8
            ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(part), i, flags, 64, 17, 0, b"\xc0\xa8\1\2", b"\xff" * 4)
            frame = bytes(12) + b"\x08\x00" + ip + part
            out += struct.pack("<IIII", START, 1000 * i, len(frame), len(frame)) + frame
    return out


def packet_inputs():
    yield "velodyne", b"\0" + velodyne(mode=0x39)
    yield "vls128", b"\0" + velodyne(0xA1, banks=4)
    yield "position", b"\0" + bytes(14) + struct.pack("<12H", *range(12)) + bytes(168) + b"$GPRMC,220243,A".ljust(306, b"\0")
    yield "hesai", b"\0" + hesai()
    yield "ouster", b"\1" + ouster()
    yield "velodyne_scan", b"\2" + scan([velodyne()])
    yield "pandar_scan", b"\2" + scan([hesai()], 1500)
    yield "cdr_scan", b"\3" + scan([velodyne()], cdr=True)
    yield "angles", b"\4Channel,Elevation,Azimuth\n1,15,0.1\n2,13.5,-0.1\n"
    yield "capture", b"\5" + capture([velodyne()] * 2, 640)


def points(count):
    """Bytes of `count` points: x y z intensity time, and ring as u16."""
    return b"".join(struct.pack("<5fH", 5 + i, 1, -0.5, 7, 0.1 * i / count, i % 16) for i in range(count))


PCD = ("VERSION 0.7\nFIELDS x y z intensity time ring\nSIZE 4 4 4 4 4 2\nTYPE F F F F F U\nCOUNT 1 1 1 1 1 1\n"
       "WIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA {1}\n")
PLY = ("ply\nformat {1} 1.0\nelement vertex {0}\nproperty float x\nproperty float y\nproperty float z\n"
       "property float intensity\nproperty float time\nproperty ushort ring\nend_header\n")


def lines(count):
    return "".join(f"{5 + i} 1 -0.5 7 {0.1 * i / count} {i % 16}\n" for i in range(count))


def compressed(count):
    """Points column by column, as runs of LZF and one match."""
    rows = points(count)
    columns, at = b"", 0
    for size in (4, 4, 4, 4, 4, 2):
        columns += b"".join(rows[22 * i + at: 22 * i + at + size] for i in range(count))
        at += size
    packed = b"".join(bytes([len(columns[i:i + 32]) - 1]) + columns[i:i + 32] for i in range(0, len(columns), 32))
    match = bytes([0, 0]) + bytes([0xE0, 22 * count - 1 - 9, 0])  # a zero, and as many more as the points take
    return struct.pack("<II", len(packed), len(columns)) + packed, struct.pack("<II", len(match), 22 * count) + match


def scan_inputs():
    yield "pcd_ascii", b"\0" + (PCD.format(3, "ascii") + lines(3)).encode()
    yield "pcd_binary", b"\0" + PCD.format(3, "binary").encode() + points(3)
    for name, body in zip(("pcd_runs", "pcd_match"), compressed(3)):
        yield name, b"\0" + PCD.format(3, "binary_compressed").encode() + body
    yield "ply_ascii", b"\1" + (PLY.format(3, "ascii") + lines(3)).encode()
    yield "ply_binary", b"\1" + PLY.format(3, "binary_little_endian").encode() + points(3)
    yield "bin", b"\2" + points(3)
    yield "columns", b"\3x y z intensity:u8 time:f64 ring:u16"


def folder_files(parts):
    """As files(), of any names; the last one ends as it does."""
    texts = [f"=== {name}\n".encode() + (content if isinstance(content, bytes) else content.encode())
             for name, content in parts.items()]
    return b"\n".join(text.removesuffix(b"\n") for text in texts[:-1]) + b"\n" + texts[-1]


def folder_inputs():
    start = 1600000000 * 10**9
    imu = "timestamp,wx,wy,wz,ax,ay,az\n" + "".join(f"{start + i * 10**7},0.01,0,0,0,0,9.8\n" for i in range(5))
    yield "names", folder_files({"imu.csv": imu, "lidar/1600000000000000000.bin": points(12)})
    yield "list", folder_files({"timestamps.txt": "1600000000.0\n1600000000.1\n", "imu.csv": imu,
                                "lidar/0.bin": points(12), "lidar/1.bin": points(12)})
    yield "pcd", folder_files({"imu.csv": imu.replace("timestamp", "# t [ns]"),
                               "lidar/1600000000100000000.pcd": PCD.format(12, "binary").encode() + points(12)})
    yield "ply", folder_files({"imu.csv": imu, "lidar/1600000000.2.ply": PLY.format(12, "ascii") + lines(12)})


def inputs():
    """(target, name, bytes) of all."""
    for compression in ("none", "bz2", "lz4"):
        yield "bag", compression, recording(LIVOX, livox, compression=compression)
    yield "bag", "no_index", recording(LIVOX, livox, index=False)
    pair = [("/a", "std_msgs/String", "ros1"), ("/b", "std_msgs/msg/String", "cdr")]
    few = [(i % 2, 1000 + 7 * (i ^ 1), bytes([i]) * (i + 3)) for i in range(8)]
    for compression in ("", "lz4", "zstd"):
        yield "mcap", compression or "none", mcap(few, pair, compression)
    # Without checksums, so that what is changed is read.
    yield "mcap", "no_index", mcap(few, pair, "zstd", index=False, crc=False)
    yield "mcap", "no_checksum", mcap(few, pair, "lz4", crc=False)
    yield "mcap", "no_chunks", mcap(few, pair, chunks=False, crc=False)
    yield "recording", "livox", recording(LIVOX, lambda t: livox(t, 120), samples=12)
    yield "recording", "ouster", recording(CLOUD, lambda t: cloud(t, "t", 6, 1e-9))
    yield "recording", "velodyne", recording(CLOUD, lambda t: cloud(t, "time", 7, 1.0), compression="bz2")
    yield "cloud", "ns", b"\0" + cloud(0, "t", 6, 1e-9)
    yield "cloud", "seconds", b"\1" + cloud(0, "time", 7, 1.0)
    yield "cloud", "absolute", b"\2" + cloud(0, "timestamp", 8, 1.0, absolute=True)
    yield "cloud", "livox", b"\3" + cloud(0, "offset_time", 6, 1e-9, line="line")
    yield "cloud", "known", b"\x3c" + cloud(0, "timestamp", 8, 1e-9, absolute=True)
    yield "cloud", "untimed", b"\0" + cloud(0, "", 0, 1.0)
    yield "livox", "message", b"\x0d" + livox(0)
    yield "livox", "from_header", b"\x1f" + livox(5)
    yield "imu", "message", b"\0" + imu(0)
    yield "imu", "samples", b"\4" + imu(0) + struct.pack("<6d", 0.1, 0.2, 0.3, 0, 0, 1) * 12
    yield "plugin", "whole", elf()
    yield "plugin", "cut", elf(8)[:300]
    yield "plugin", "text", b"not a shared object"
    yield "tum", "walk", tum(10, 20).encode()
    yield "tum", "exponents", b"# t x y z qx qy qz qw\n1.6e9 1 2 3 0 0 0 1\n1.600000001e+09 1 2 3.5 0 0 1e-3 1\n"
    yield "reference", "tum", tum(10, 20).encode()
    yield "reference", "euroc", (b"#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\r\n"
                                 b"1600000000250000000,1,2,3,1,0,0,0\r\n1600000000350000000,4,5,6,0.6,0,0.8,0\r\n")
    yield "reference", "newer_college", (b"\xef\xbb\xbf#sec,nsec,x,y,z,qx,qy,qz,qw\n1600000000,250000000,1,2,3,0,0,0,1\n"
                                         b"1600000000,350000000,4,5,6,0,0,0,1\n")
    yield "reference", "mulran", b"1600000000250000000,1,0,0,1,0,1,0,2,0,0,1,3\n1600000000350000000,1,0,0,4,0,1,0,5,0,0,1,6\n"
    yield "reference", "kitti", b"1 0 0 1 0 1 0 2 0 0 1 3\n1 0 0 4 0 1 0 5 0 0 1 6\n"
    yield "reference", "positions", b"% by hand\n1.6e9 744073.3 2553112.0 0.2\n1.600000001e+09 744074.3 2553112.0 0.2\n"
    yield "reference", "digits", b"1.6e9 1 2 3\n1.6e9 2 2 3\n1.6e9 3 2 3\n"
    yield "csv", "results", (RESULTS + 'a,a,1,0,b,ok,"a ""quoted"", one",0.05,0.2,10\n').encode()
    yield "csv", "updates", updates(6).encode()
    yield "text", "hostile", HOSTILE.encode() + b"\xff\0|`*[]{}$%_^~\\\r\n"
    for target, made in (("report", report_inputs), ("outcomes", outcome_inputs), ("study", study_inputs),
                         ("kitti", kitti_inputs), ("packets", packet_inputs), ("scan", scan_inputs), ("folder", folder_inputs)):
        for name, content in made():
            yield target, name, content
    for target, name, content in (
            ("pipeline", "flow", "schema: aslio/pipeline/1\nwindow: {type: fixed, period: 0.1}\nmap: voxel_hash\n"),
            ("sensor", "all_keys", "schema: aslio/sensor/1\nacc_unit: g\ngyro_unit: rad_s\nT_imu_lidar: {translation: [0, 0, 0.1], "
             "rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\ngyro_sensitivity: [0, 0, 0, 0, 0, 0, 0, 0, 0.01]\nimu_delay: 0.01\n"
             "scan_lines: 6\nmin_range: 0.5\nmax_range: 100\nsweep_period: 0.1\n"),
            ("scene", "stress", "schema: aslio/scene/1\nworld: {type: garage}\nstress: {clock_offset: 1, imu_loss: 0.1}\n"),
            ("scene", "follow", "schema: aslio/scene/1\nworld: {type: mesh, file: room.obj}\nfollow: {file: walk.tum}\n"),
            ("sensor", "refused", "schema: aslio/sensor/1\n? [a, b]\n: &x !!str {<<: *x, 'q': \"\\u00e9\\n\", a: 1, a: 2}\n")):
        yield target, name, content.encode()


def main(arguments):
    folder = pathlib.Path(arguments[0]) if arguments else HERE / "corpus"
    for target, name, content in inputs():
        path = folder / target / f"{name}.input"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
