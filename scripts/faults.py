#!/usr/bin/env python3
"""Attacks a build of simrun as a bad night would, and says what happened.

    scripts/faults.py                       every attack; the table goes to stdout
    scripts/faults.py kill disk             those whose names begin so
    scripts/faults.py --write               also renews the table in docs/book/src/reliability.md

Each attack has a folder of its own that is thrown away. What a run must end in is what an undisturbed run of the same
command wrote, byte for byte. Instants and offsets come from a seeded generator, so that a second call tries the same
ones, but for what the machine's speed makes of an instant. Linux and Python 3.10, no packages. The small disk is a
tmpfs, which takes root: without it that attack says `skipped`.
"""

import argparse
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/book/src/reliability.md"
BEGIN, END = "<!-- faults: written by scripts/faults.py -->", "<!-- end of faults -->"
# Wall-clock figures and what says which build and host wrote the folder are no results.
NO_RESULT = {"timings.csv", "manifest.json", ".lock"}
RUN = ["run", "scenarios/warehouse.yaml", "--episodes", "12"]
SWEEP = ["run", "scenarios/sweeps/dwa_horizon_weight.yaml", "--episodes", "4"]
TRACE = ["run", "scenarios/05_crossing.yaml", "--episodes", "12", "--trace"]
PAPER = ["reproduce", "gao2025", "--episodes", "3"]


class Fault(Exception):
    """A promise that was not kept."""


class Skipped(Exception):
    """This machine cannot try it."""


def need(condition, *said):
    if not condition:
        raise Fault(" ".join(str(word) for word in said))


class Attacker:
    def __init__(self, simrun, folder):
        self.simrun, self.folder, self.random = simrun, folder, random.Random(20261127)
        self.whole_runs = {}

    def start(self, arguments, out=None, **options):
        command = [self.simrun, *map(str, arguments), "--quiet"] + (["--out", str(out)] if out else [])
        options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "cwd": ROOT} | options
        return subprocess.Popen(command, **options)

    def call(self, arguments, out=None, code=0, **options):
        """Runs it to its end, which must come with this code; stdout and stderr."""
        process = self.start(arguments, out, **options)
        said = "".join(process.communicate())
        codes = code if isinstance(code, tuple) else (code,)
        need(process.returncode in codes, f"exit code {process.returncode}, not {code}:", " ".join(map(str, arguments)), "\n", said[-2000:])
        return said

    def fresh(self, name):
        path = self.folder / name
        shutil.rmtree(path, ignore_errors=True)
        return path

    def whole(self, arguments):
        """What an undisturbed run writes, file by file, and the seconds that it takes."""
        key = " ".join(map(str, arguments))
        if key not in self.whole_runs:
            out = self.fresh(f"whole{len(self.whole_runs)}")
            start = time.monotonic()
            self.call(arguments, out)
            self.whole_runs[key] = (results(out), time.monotonic() - start)
        return self.whole_runs[key]

    def same(self, out, arguments, why):
        want, got = self.whole(arguments)[0], results(out)
        names = sorted(name for name in want.keys() | got.keys() if want.get(name) != got.get(name))
        need(not names, why, "differs from an undisturbed run in", names)


def results(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name not in NO_RESULT
    }


def begun(attacker, out):
    """A run that has written its first rows."""
    process = attacker.start(RUN, out)
    while not (out / "episodes.csv").exists() and process.poll() is None:
        time.sleep(0.01)
    return process


def kill_and_go_on(attacker, arguments, kills, with_signal, prepare=None):
    """Kills runs of one command at random instants, going on in between, until there were enough kills; compares each
    folder that came to its end. Returns the number of kills."""
    _, whole_s = attacker.whole(arguments)
    done = 0
    while done < kills:
        out = attacker.fresh("killed")
        if prepare:
            prepare(out)
        while True:
            process = attacker.start(arguments, out)
            try:
                process.communicate(timeout=attacker.random.uniform(0.02, 0.7 * whole_s) if done < kills else None)
            except subprocess.TimeoutExpired:
                process.send_signal(with_signal)
                said = "".join(process.communicate())
                if process.returncode == 0:
                    break
                done += 1
                if with_signal == signal.SIGKILL:
                    need(process.returncode == -signal.SIGKILL, "exit code", process.returncode, said)
                else:
                    need(process.returncode == 128 + with_signal, "exit code", process.returncode, said)
                continue
            need(process.returncode == 0, "going on ended with", process.returncode, process.stderr)
            break
        attacker.same(out, arguments, "a killed run")
    return done


ATTACKS = []


def attack(name, promise, fault, command=None):
    def keep(function):
        ATTACKS.append((name, promise, fault, command or f"scripts/faults.py {name}", function))
        return function

    return keep


@attack("kill-run", "Nothing written is lost or torn", "`kill -9` of a run at random instants, then the same command again")
def kill_run(a):
    kills = kill_and_go_on(a, RUN, 20, signal.SIGKILL)
    return kills, "every folder that came to its end is an undisturbed run's, byte for byte"


@attack("kill-sweep", "Nothing written is lost or torn", "the same in a sweep")
def kill_sweep(a):
    kills = kill_and_go_on(a, SWEEP, 10, signal.SIGKILL)
    return kills, "the same"


@attack("kill-extension", "Nothing written is lost or torn", "the same while 4 episodes are extended to 12")
def kill_extension(a):
    short = RUN[:-1] + ["4"]
    kills = kill_and_go_on(a, RUN, 10, signal.SIGKILL, prepare=lambda out: a.call(short, out))
    return kills, "the same"


@attack("kill-trace", "Nothing written is lost or torn", "the same with `--trace`")
def kill_trace(a):
    kills = kill_and_go_on(a, TRACE, 10, signal.SIGKILL)
    return kills, "the same, the traces too"


@attack("kill-reproduce", "Nothing written is lost or torn", "the same in `reproduce`")
def kill_reproduce(a):
    kills = kill_and_go_on(a, PAPER, 10, signal.SIGKILL)
    return kills, "the same, tables and report"


@attack("kill-force", "Nothing written is lost or torn", "`kill -9` while `--force` replaces a finished run with another seed")
def kill_force(a):
    other = RUN + ["--seed", "77"]
    _, whole_s = a.whole(other)
    old = a.whole(RUN)[0]
    for _ in range(10):
        out = a.fresh("forced")
        a.call(RUN, out)
        process = a.start(other + ["--force"], out)
        try:
            process.communicate(timeout=a.random.uniform(0.0, 0.5 * whole_s))
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
        if results(out) != old:
            a.call(other, out)
            a.same(out, other, "a replaced run")
    return 10, "the old run is whole, or the new one is gone on with; never rows of both"


@attack("interrupt", "Ctrl-C finishes what is in hand", "SIGINT at random instants, then the same command again")
def interrupt(a):
    kills = kill_and_go_on(a, RUN, 20, signal.SIGINT)
    return kills, "exit code 130 each time; undisturbed tables in the end"


@attack("terminate", "Ctrl-C finishes what is in hand", "SIGTERM in a sweep, then the same command again")
def terminate(a):
    kills = kill_and_go_on(a, SWEEP, 10, signal.SIGTERM)
    return kills, "exit code 143 each time; undisturbed tables in the end"


@attack("disk", "A full disk is an error and not a loss", "a disk of 400 kB, filled beforehand to every level from empty to full in steps of 8 kB; then room is made and the command given again")
def disk(a):
    mount = a.fresh("disk")
    mount.mkdir()
    size, step = 400_000, 8_192
    if os.geteuid() or subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "simrun-faults", mount], capture_output=True).returncode:
        raise Skipped("cannot mount a tmpfs")
    try:
        levels = full = 0
        for level in range(0, size + step, step):
            filler, out = mount / "filler", mount / "out"
            try:
                with open(filler, "wb") as file:
                    file.write(b"x" * level)
            except OSError:
                pass
            process = a.start(RUN, out)
            said = "".join(process.communicate())
            if process.returncode:
                need(process.returncode == 1 and "No space left" in said, "exit code", process.returncode, said)
                full += 1
            filler.unlink(missing_ok=True)
            a.call(RUN, out)
            a.same(out, RUN, f"a disk with {level} bytes taken")
            shutil.rmtree(out)
            levels += 1
        need(full > 0, "no level was full")
    finally:
        subprocess.run(["umount", mount], check=True)
    return levels, "exit code 1 with the file and the reason where it did not fit; undisturbed tables once there was room"


@attack("truncate", "Nothing written is lost or torn", "`episodes.csv` cut at a random byte, half of them without `summary.csv`, then the same command again")
def truncate(a):
    out = a.fresh("cut")
    a.call(RUN[:-1] + ["4"], out)
    four = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
    for turn in range(40):
        for name, content in four.items():
            (out / name).write_bytes(content)
        with open(out / "episodes.csv", "r+b") as file:
            file.truncate(a.random.randrange(len(four["episodes.csv"])))
        if turn % 2:
            (out / "summary.csv").unlink(missing_ok=True)
        said = a.call(RUN, out, code=(0, 1))
        if "altered" in said or "hash" in said:
            continue
        a.same(out, RUN, "a table that was cut")
    return 40, "the cut row is driven again, or the alteration is named; undisturbed tables in the end"


@attack("flip", "A finished table that was altered is noticed", "one bit of a finished `episodes.csv`, `states.csv` or `summary.csv` flipped")
def flip(a):
    out = a.fresh("flipped")
    a.call(RUN, out)
    noticed = 0
    names = ["episodes.csv", "states.csv", "summary.csv"]
    for turn in range(150):
        path = out / names[turn % 3]
        whole = path.read_bytes()
        bad = bytearray(whole)
        bad[a.random.randrange(len(bad))] ^= 1 << a.random.randrange(8)
        path.write_bytes(bad)
        process = a.start(RUN, out)
        said = "".join(process.communicate())
        mended = path.read_bytes() == whole
        need(process.returncode != 0 or mended, f"bit {turn} of {path.name} was taken:", said)
        path.write_bytes(whole)
        noticed += 1
    a.call(RUN, out)
    return 150, "refused with the file named, or made anew from what is whole; none was taken"


@attack("two-processes", "One folder, one writer", "a second process in the folder of a running one; then `--wait-lock`")
def two_processes(a):
    for _ in range(5):
        out = a.fresh("shared")
        first = begun(a, out)
        second = a.start(RUN, out)
        said = "".join(second.communicate())
        if first.poll() is None:
            need(second.returncode == 75, "exit code", second.returncode, said)
        a.call(RUN + ["--wait-lock", "600"], out)
        first.communicate()
        a.same(out, RUN, "a folder that two processes wanted")
    return 5, "exit code 75 at once; `--wait-lock` waits and finds the run complete"


@attack("removed", "A folder removed under way is noticed", "`rm -r` of the results of a run under way")
def removed(a):
    for _ in range(5):
        out = a.fresh("removed")
        process = begun(a, out)
        shutil.rmtree(out, ignore_errors=True)
        said = "".join(process.communicate())
        need(process.returncode == 1, "exit code", process.returncode, said)
        need(not (out / "episodes.csv").exists(), "rows went nowhere")
    return 5, "exit code 1 at the next world, with the folder named"


@attack("changed-file", "Rows of two worlds never mix", "a map and a recording changed between two calls of one command")
def changed_file(a):
    tried = 0
    for name in ("07_movingai.yaml", "12_recorded_people.yaml"):
        place = a.fresh("changed")
        shutil.copytree(ROOT / "scenarios", place / "scenarios")
        text = (place / "scenarios" / name).read_text()
        named = [word for word in re.findall(r"[\w./-]+\.(?:map|csv|yaml|png|pgm)", text) if (place / "scenarios" / word).is_file()]
        for word in named:
            out = a.fresh("changed_out")
            call = ["run", place / "scenarios" / name]
            a.call(call + ["--episodes", "2"], out)
            victim = place / "scenarios" / word
            whole = victim.read_bytes()
            victim.write_bytes(whole + (b"# changed\n" if word.endswith("yaml") else b"\n"))
            process = a.start(call + ["--episodes", "4"], out)
            said = "".join(process.communicate())
            need(process.returncode not in (0, -6, 101), word, "changed and was taken:", said)
            need(pathlib.Path(word).name in said, word, "is not named:", said)
            victim.write_bytes(whole)
            tried += 1
    need(tried, "no scenario names a file")
    return tried, "refused with the file named; rows untouched"


@attack("read-only", "A finished folder can be shown", "a finished folder without permission to write, shown by the command that made it")
def read_only(a):
    if os.geteuid() == 0:
        # Root may write everywhere: a bind mount that is read-only stops it too.
        out = a.fresh("read_only")
        a.call(RUN, out)
        if subprocess.run(["mount", "--bind", out, out], capture_output=True).returncode:
            raise Skipped("cannot mount")
        try:
            subprocess.run(["mount", "-o", "remount,ro,bind", out], check=True, capture_output=True)
            a.call(RUN, out)
        finally:
            subprocess.run(["umount", out], check=True)
        return 1, "shown, exit code 0"
    out = a.fresh("read_only")
    a.call(RUN, out)
    out.chmod(0o555)
    a.call(RUN, out)
    out.chmod(0o755)
    return 1, "shown, exit code 0"


@attack("kill-child", "A bad episode is a row", "`kill -9` of a child process of `--isolate` at a random instant")
def kill_child(a):
    whole, whole_s = a.whole(RUN)
    killed = 0
    while killed < 10:
        out = a.fresh("isolated")
        process = a.start(RUN + ["--isolate"], out)
        time.sleep(a.random.uniform(0.05, 0.5 * whole_s))
        children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children")
        children = [int(pid) for path in children.parent.parent.glob("*/children") for pid in path.read_text().split()] if children.exists() else []
        if not children:
            process.communicate()
            continue
        try:
            os.kill(a.random.choice(children), signal.SIGKILL)
        except ProcessLookupError:
            pass
        said = "".join(process.communicate())
        rows = (out / "episodes.csv").read_text().splitlines()
        lost = [row for row in rows if ",internal_error," in row]
        need(process.returncode == (1 if lost else 0), "exit code", process.returncode, said)
        need(all("SIGKILL" in row for row in lost), "the signal is not named:", lost)
        others = zip(rows, whole["episodes.csv"].decode().splitlines())
        need(sum(got != want for got, want in others) == len(lost), "other rows than the lost ones differ")
        killed += 1
    return 10, "at most the row in hand is `internal_error` with SIGKILL named; all others are those of a run without `--isolate`"


@attack("isolate", "The same scenario and seed, the same bytes", "a run with `--isolate --give-up-after 60`, killed at random instants and gone on with")
def isolate(a):
    for _ in range(3):
        out = a.fresh("isolated")
        call = RUN + ["--isolate", "--give-up-after", "60"]
        process = a.start(call, out)
        time.sleep(a.random.uniform(0.1, 0.7 * a.whole(RUN)[1]))
        process.kill()
        process.communicate()
        a.call(call, out)
        a.same(out, RUN, "an isolated run")
    return 3, "the table of a run without it"


@attack("threads", "The same scenario and seed, the same bytes", "1, 2, 3, 8 and 64 threads, another locale and time zone, an empty environment")
def threads(a):
    tried = 0
    for number in (1, 2, 3, 8, 64):
        out = a.fresh("threads")
        a.call(RUN + ["--threads", number], out)
        a.same(out, RUN, f"{number} threads")
        tried += 1
    for env in ({}, {"LC_ALL": "tr_TR.UTF-8", "TZ": "Asia/Kathmandu", "COLUMNS": "20"}):
        out = a.fresh("threads")
        a.call(RUN, out, env=env)
        a.same(out, RUN, f"the environment {env}")
        tried += 1
    return tried, "one table"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("names", nargs="*", help="attacks whose names begin so; all without")
    parser.add_argument("--simrun", default=str(ROOT / "target/release/simrun"), help="the program to attack")
    parser.add_argument("--write", action="store_true", help="renew the table of docs/book/src/reliability.md")
    args = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
    rows, broken = [], 0
    with tempfile.TemporaryDirectory(prefix="simrun-faults-") as folder:
        attacker = Attacker(args.simrun, pathlib.Path(folder))
        for name, promise, fault, command, function in ATTACKS:
            if args.names and not any(name.startswith(word) for word in args.names):
                continue
            start = time.monotonic()
            try:
                count, said = function(attacker)
            except Skipped as why:
                count, said = 0, f"skipped: {why}"
            except Fault as fault_found:
                count, said = 0, f"BROKEN: {fault_found}"
                broken += 1
            print(f"{name}: {count} times: {said} ({time.monotonic() - start:.0f} s)", file=sys.stderr)
            rows.append(f"| {promise} | {fault} | {count} | {said} | `{command}` |")
    head = ["| promise | fault tried | times | what happened | command |", "|---|---|---|---|---|"]
    table = "\n".join(head + rows)
    print(table)
    if args.write and not broken:
        text = PAGE.read_text()
        before, rest = text.split(BEGIN)
        PAGE.write_text(before + BEGIN + "\n\n" + table + "\n\n" + END + rest.split(END)[1])
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
