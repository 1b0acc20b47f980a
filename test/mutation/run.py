#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Mutation score of the code that decides: one small change at a time, and the tests of its room must fail.

    python3 test/mutation/run.py [--mutants N] [--seed S] [--room NAME] [--list]

N mutants (default 60) are drawn evenly from the rooms, the same for the same seed. Only the changed body is compiled,
with precompiled headers, and linked before the libraries of the release preset, of which its functions then take the
place. Survivors are printed, with the reason if test/mutation/survivors.txt has one. Exit code 1 below 85 % killed.
"""
import argparse
import collections
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "mutation"
RELEASE = ROOT / "build" / "release"
LEAST_SCORE = 0.85
LIBRARIES = ["eval", "testing", "pipeline", "filters", "motion", "evidence", "late", "cluster", "geometry", "correspondence", "config",
             "io", "core"]
# `users` of changed headers: the bodies that the header's functions are compiled into.
Room = collections.namedtuple("Room", "name bodies tests users", defaults=[[]])
ROOMS = [
    Room("combinators",
         ["pipeline/detail/logic_stages-inl.hpp", "pipeline/detail/routing_stages-inl.hpp",
          "pipeline/detail/vote_stage-inl.hpp", "pipeline/detail/temporal_stage-inl.hpp",
          "pipeline/detail/object_vote-inl.hpp", "pipeline/detail/stage-inl.hpp"],
         ["pipeline/combinators_test.cpp", "pipeline/object_stages_test.cpp", "pipeline/pipeline_test.cpp"]),
    Room("votes", ["pipeline/judgement.hpp", "core/votes.hpp"],
         ["pipeline/judgement_test.cpp", "pipeline/combinators_test.cpp"],
         ["pipeline/detail/logic_stages-inl.hpp", "pipeline/detail/routing_stages-inl.hpp",
          "pipeline/detail/vote_stage-inl.hpp", "pipeline/detail/temporal_stage-inl.hpp",
          "pipeline/detail/stage-inl.hpp", "pipeline/detail/combinator-inl.hpp"]),
    Room("floor", ["pipeline/detail/floor-inl.hpp"], ["pipeline/floor_test.cpp"]),
    Room("residuals", ["geometry/rigid_residual.hpp", "motion/static_miss.hpp",
                       "geometry/detail/rigid_misses-inl.hpp"],
         ["motion/static_miss_test.cpp", "geometry/rigid_misses_test.cpp", "geometry/rigid_motion_test.cpp"]),
    Room("background", ["motion/detail/rigid_background-inl.hpp"],
         ["motion/background_score_test.cpp", "motion/rigid_background_test.cpp",
          "filters/background_motion_test.cpp"]),
    Room("dbscan", ["cluster/detail/density_clusters-inl.hpp", "filters/detail/adaptive_dbscan.hpp", "cluster/clusters.hpp"],
         ["cluster/dbscan_test.cpp", "filters/adaptive_dbscan_test.cpp"],
         ["cluster/detail/density_clusters-inl.hpp", "filters/detail/dbscan-inl.hpp"]),
    Room("epipolar", ["filters/detail/epipolar-inl.hpp", "geometry/detail/epipolar_distance-inl.hpp"],
         ["filters/epipolar_test.cpp", "geometry/epipolar_test.cpp"]),
]

# Binary operators have blanks around them, which template brackets and signs have not: clang-format sees to it.
CHANGES = [
    (re.compile(r" < "), " >= "), (re.compile(r" <= "), " > "), (re.compile(r" > "), " <= "),
    (re.compile(r" >= "), " < "), (re.compile(r" == "), " != "), (re.compile(r" != "), " == "),
    (re.compile(r" && "), " || "), (re.compile(r" \|\| "), " && "),
    (re.compile(r" \+ "), " - "), (re.compile(r" - "), " + "), (re.compile(r" \* "), " / "),
    (re.compile(r" / "), " * "), (re.compile(r" \+= "), " -= "), (re.compile(r"\bstd::max\b"), "std::min"),
    (re.compile(r"\bstd::min\b"), "std::max"), (re.compile(r"\btrue\b"), "false"),
    (re.compile(r"\bfalse\b"), "true"), (re.compile(r"Vote::Dynamic\b"), "Vote::Static"),
    (re.compile(r"Vote::Static\b"), "Vote::Dynamic"), (re.compile(r"Vote::Unknown\b"), "Vote::Static"),
]
NUMBER = re.compile(r"(?<![\w.\"])(\d+\.\d+(?:e-?\d+)?|\d+)(?=[FU]?\b)(?![\w.]*\")")
# Tables of parameters are checked against the documentation, notes are words, a reserved size changes nothing.
SKIPPED = re.compile(r"^\s*(//|#|\*|static_assert)|\b(real|reals|integer|flag|choice|texts?)\(\"|reserve\(|note|message")

Mutant = collections.namedtuple("Mutant", "room body line before after")


def changed_number(text):
    value = float(text)
    new = 1.0 if value == 0 else value * 2
    return repr(new) if "." in text else str(int(new))


def mutants_of(room, body):
    lines = (ROOT / "include/dynfilter" / body).read_text().splitlines()
    in_table = False
    for number, line in enumerate(lines):
        in_table = (in_table or "FieldTable<" in line) and line.strip() != "};"
        if in_table or SKIPPED.search(line):
            continue
        code = line.split(" //")[0]
        quoted = [m.span() for m in re.finditer(r'"(\\.|[^"])*"', code)]
        changes = [(m, after) for pattern, after in CHANGES for m in pattern.finditer(code)]
        changes += [(m, changed_number(m.group())) for m in NUMBER.finditer(code)]
        for match, after in changes:
            if not any(a <= match.start() < b for a, b in quoted):
                yield Mutant(room, body, number, line, line[:match.start()] + after + line[match.end():])


def sampled(count, seed, only):
    rooms = [room for room in ROOMS if only in (None, room.name)]
    draw = random.Random(seed)
    queues = []
    for room in rooms:
        found = [m for body in room.bodies for m in mutants_of(room, body)]
        draw.shuffle(found)
        queues.append(found)
    chosen = []
    while len(chosen) < count and any(queues):
        for queue in queues:
            if queue and len(chosen) < count:
                chosen.append(queue.pop())
    return chosen, sum(len(q) for q in queues) + len(chosen)


def flags():
    packages = subprocess.run(["pkg-config", "--cflags-only-I", "opencv4", "eigen3"], capture_output=True, text=True,
                              check=True).stdout.replace("-I", "-isystem").split()
    return ["-std=c++17", "-O1", "-g0", "-w", "-fPIC", *packages, f"-I{ROOT}/include", f"-I{ROOT}/test",
            f'-DDYNFILTER_SOURCE_DIR="{ROOT}"', f'-DDYNFILTER_DATA_DIR="{ROOT}/../shared/data"']


COMPILER = os.environ.get("CXX", "g++")


def compile_one(source, output, first=()):
    cache = [] if first or not shutil.which("ccache") else ["ccache"]
    return subprocess.run([*cache, COMPILER, *first, *flags(), "-c", str(source), "-o", str(output)],
                          capture_output=True, text=True)


def included_by(source):
    """The headers that a source includes, as the compiler names them."""
    result = subprocess.run([COMPILER, *flags(), "-M", str(source)], capture_output=True, text=True, check=True)
    return result.stdout.replace("\\\n", " ").split()[2:]


def precompiled(room, body):
    """A header with what a changed file includes, precompiled, since that takes most of the time.
    A changed header takes part in other headers of dynfilter, so only those of others are precompiled for it."""
    is_header = not body.endswith("-inl.hpp")
    header = BUILD / f"{room.name}_{'others' if is_header else 'all'}.hpp"
    if header in READY:
        return header
    bodies, sources = (room.users, room.tests) if is_header else (room.bodies, [])
    source = BUILD / "closure.cpp"
    source.write_text("".join(f"#include <dynfilter/{b}>\n" for b in bodies if b.endswith("-inl.hpp")) +
                      "".join(f"#include <{t}>\n" for t in sources))
    own, changed = str(ROOT / "include"), {str(ROOT / "include/dynfilter" / b) for b in room.bodies}
    names = [n for n in included_by(source) if n.startswith(own) and "-inl.hpp" not in n and n not in changed]
    if is_header:
        lines = {line.strip() for name in names for line in pathlib.Path(name).read_text().splitlines()}
        names = sorted(line[10:-1] for line in lines if re.match(r"#include <(opencv2|Eigen|[a-z]+>)", line))
    else:
        names = sorted(n[len(own) + 1:] for n in names)
    header.write_text(("" if is_header else "#define DYNFILTER_LIBRARY\n") + "".join(f"#include <{n}>\n" for n in names))
    result = subprocess.run([COMPILER, *flags(), "-x", "c++-header", str(header), "-o", f"{header}.gch"],
                            capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{header} does not compile:\n{result.stderr[:2000]}")
    READY.add(header)
    return header


READY = set()


def test_object(test):
    output = BUILD / "tests" / (test.replace("/", "_") + ".o")
    source = ROOT / "test" / test
    newest = max(f.stat().st_mtime for folder in ("include", "test") for f in (ROOT / folder).rglob("*.[ch]pp"))
    if not output.exists() or output.stat().st_mtime < newest:
        output.parent.mkdir(parents=True, exist_ok=True)
        result = compile_one(source, output)
        if result.returncode != 0:
            sys.exit(f"{test} does not compile:\n{result.stderr[:2000]}")
    return output


def program_of(room, first, name):
    """Links what `first` replaces before the libraries: of two definitions the linker takes the first."""
    libraries = [str(RELEASE / f"libdynfilter_{name}.a") for name in LIBRARIES]
    modules = [f"-lopencv_{m}" for m in ["calib3d", "video", "imgproc", "imgcodecs", "core"]] + ["-llz4"]
    output = BUILD / name
    objects = [str(o) for o in first] + [str(test_object(t)) for t in ["test_main.cpp", *room.tests]]
    result = subprocess.run(["g++", "-Wl,-z,muldefs", *objects, "-Wl,--start-group", *libraries, "-Wl,--end-group",
                             *modules, "-lpthread", "-o", str(output)], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"room {room.name} does not link:\n{result.stderr[:3000]}")
    return output


def passes(program, limit_s):
    try:
        command = [str(program), "--abort-after=1", "--test-suite-exclude=shared_data"]
        return subprocess.run(command, capture_output=True, timeout=limit_s).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def changed_objects(mutant):
    """The body, or for a header its tests and users, whose copies of the header's functions then are the first."""
    overlay = BUILD / "overlay"
    target = overlay / "dynfilter" / mutant.body
    for old in overlay.rglob("*.hpp"):
        old.unlink()
    target.parent.mkdir(parents=True, exist_ok=True)
    lines = (ROOT / "include/dynfilter" / mutant.body).read_text().splitlines()
    lines[mutant.line] = mutant.after
    target.write_text("\n".join(lines) + "\n")
    bodies, sources, objects = [mutant.body], [BUILD / "body.cpp"], []
    if not mutant.body.endswith("-inl.hpp"):
        bodies = mutant.room.users
        sources += [ROOT / "test" / test for test in mutant.room.tests]
    sources[0].write_text("#define DYNFILTER_LIBRARY\n" + "".join(f"#include <dynfilter/{b}>\n" for b in bodies))
    first = ["-include", str(precompiled(mutant.room, mutant.body)), f"-I{overlay}"]
    for k, source in enumerate(sources):
        output = BUILD / f"changed_{k}.o"
        if compile_one(source, output, first).returncode != 0:
            return None
        objects.append(output)
    return objects


def outcome(mutant, limit_s):
    objects = changed_objects(mutant)
    if objects is None:
        return "does not compile"
    room = mutant.room if mutant.body.endswith("-inl.hpp") else mutant.room._replace(tests=[])
    return "survived" if passes(program_of(room, objects, "mutant"), limit_s) else "killed"


def known_reasons():
    """Lines `BODY | BEFORE | AFTER | REASON`."""
    file = pathlib.Path(__file__).with_name("survivors.txt")
    rows = [line.split(" | ") for line in file.read_text().splitlines() if line and line[0] != "#"]
    return {tuple(part.strip() for part in row[:3]): row[3].strip() for row in rows}


def limits_of(rooms):
    """Ten times what the tests take unchanged, and at least 30 s: the machine may be busy."""
    limits = {}
    for room in rooms:
        program = program_of(room, [], "unchanged")
        begin = time.monotonic()
        if not passes(program, 600):
            sys.exit(f"the tests of room {room.name} fail without a change")
        limits[room.name] = max(30.0, 10 * (time.monotonic() - begin))
        print(f"{room.name}: the tests take {time.monotonic() - begin:.1f} s", flush=True)
    return limits


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mutants", type=int, default=60)
    parser.add_argument("--seed", type=int, default=26)
    parser.add_argument("--room", choices=[room.name for room in ROOMS])
    parser.add_argument("--list", action="store_true", help="print the mutants, run none")
    options = parser.parse_args()
    chosen, possible = sampled(options.mutants, options.seed, options.room)
    if options.list:
        for m in chosen:
            print(f"{m.body}:{m.line + 1}\n  - {m.before.strip()}\n  + {m.after.strip()}")
        return 0
    BUILD.mkdir(parents=True, exist_ok=True)
    targets = [f"dynfilter_{name}" for name in LIBRARIES]
    built = subprocess.run(["cmake", "--build", "--preset", "release", "-j1", "--target", *targets], cwd=ROOT,
                           capture_output=True, text=True)
    if built.returncode != 0:
        sys.exit(f"configure the preset release first, its libraries are linked:\n{built.stdout[-2000:]}{built.stderr}")
    limits = limits_of([room for room in ROOMS if any(m.room is room for m in chosen)])
    reasons = known_reasons()
    counts = collections.defaultdict(collections.Counter)
    for m in chosen:
        result = outcome(m, limits[m.room.name])
        counts[m.room.name][result] += 1
        if result != "survived":
            continue
        reason = reasons.get((m.body, m.before.strip(), m.after.strip()), "no reason is known: a test is missing")
        print(f"survived: {m.body}:{m.line + 1}\n  - {m.before.strip()}\n  + {m.after.strip()}\n  {reason}", flush=True)
    total = sum(counts.values(), collections.Counter())
    for name, count in counts.items():
        print(f"{name}: {count['killed']} of {count['killed'] + count['survived']} killed")
    ran = total["killed"] + total["survived"]
    score = total["killed"] / max(1, ran)
    print(f"{total['killed']} of {ran} mutants killed, {100 * score:.1f} %; {total['does not compile']} do not compile; "
          f"{possible} are possible; seed {options.seed}")
    return 0 if score >= LEAST_SCORE else 1


if __name__ == "__main__":
    sys.exit(main())
