"""Programs as controllers.

The protocol, every kind of misbehaviour, and that no process is left behind.
"""

import json
import math
import re
import select
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sim import Command, Observation, ProcessController, RunOptions, simulate
from sim.controllers import CONTROLLERS
from sim.controllers.examples.python import Example
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import InvalidParameter, Pose, Target, World, generate, read_world

BOUNCE_C = Path(__file__).parents[1] / "data" / "controllers" / "bounce.c"
PYTHON = [sys.executable, "-I", "-S", "-c"]
SERVE = """
import json, os, subprocess, sys, time
def answer(text):
    print(text, flush=True)
step = 0
for line in sys.stdin:
    if "reset" in json.loads(line):
        step = 0
        continue
    step += 1
    if step == AT:
        DO
    else:
        answer('{"speed": 0.1, "turn_rate": 0.5}')
"""
linux = pytest.mark.skipif(
    sys.platform != "linux", reason="memory limits of programs are for Linux"
)


def program(do="", at=3):
    """Return the command of a program that drives in a circle.

    Optionally it does something else in one step of each episode.
    """
    return [
        *PYTHON,
        SERVE.replace("AT", str(at if do else 0)).replace(
            "DO", (do or "pass").replace("\n", "\n        ")
        ),
    ]


def arena():
    return World(np.zeros((12, 12), bool), Pose(0.55, 0.55, 0.0), Target(1.05, 1.05, 0.05))


def run(command, steps=20, **limits):
    with ProcessController(command, **limits) as controller:
        return simulate(arena(), controller, RunOptions(steps=steps))


def is_running(process_id):
    state = subprocess.run(
        ["ps", "-o", "stat=", "-p", str(process_id)], capture_output=True, text=True, check=False
    )
    return bool(state.stdout.strip()) and not state.stdout.startswith("Z")


def waits_for(condition, seconds):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


def ends(process_id):
    return waits_for(lambda: not is_running(process_id), 30.0)


@pytest.mark.gate
@pytest.mark.parametrize(
    ("do", "error"),
    [
        pytest.param("sys.exit(3)", "exit code 3", id="exits-3"),
        pytest.param("sys.exit(0)", "exit code 0", id="exits-early"),
        pytest.param("1 / 0", "exit code 1", id="raises"),
        pytest.param("os.kill(os.getpid(), 11)", "killed by SIGSEGV", id="segfault"),
        pytest.param("sys.stdout.write('{'); sys.exit(2)", "exit code 2", id="exits-amid-a-line"),
        pytest.param("os.close(1); time.sleep(60)", "closed its output", id="closes-its-output"),
    ],
)
@pytest.mark.parametrize("step", [1, 5])
def test_a_program_that_ends_is_a_crash_that_says_how(do, error, step):
    episode = run(program(do, at=step))
    assert (episode.verdict, episode.steps) == ("crash", step)
    assert (episode.evidence.error, episode.evidence.step) == (error, step)


def test_a_crash_keeps_the_last_lines_of_stderr_as_plain_text():
    do = (
        r"for k in range(9000): print(f'line {k}', file=sys.stderr)"
        "\n"
        r"sys.exit('\x1b[31mred\x00\xff ' + 300 * 'x')"
    )
    said = run(program(do)).evidence.stderr
    assert said[:4] == ("line 8996", "line 8997", "line 8998", "line 8999") and said[4] == 200 * "x"


@pytest.mark.gate
@pytest.mark.parametrize("step", [1, 3])
def test_a_program_that_does_not_answer_hangs(step):
    first = 0.5 if step == 1 else 30.0
    episode = run(program("time.sleep(60)", at=step), deadline=1.0, start_deadline=first)
    assert (episode.verdict, episode.steps, episode.evidence.error) == ("hang", step, "no answer")
    assert episode.evidence.deadline == (first if step == 1 else 1.0)


def test_drips_of_an_answer_do_not_put_off_the_deadline():
    do = (
        "for _ in range(1200):\n    sys.stdout.write(' '); sys.stdout.flush(); "
        "time.sleep(0.05)\nsys.exit(5)"
    )
    assert (
        run(program(do), deadline=0.3).verdict == "hang"
    )  # a crash if worldgen waited for the last drip


def test_a_flood_of_stderr_does_not_put_off_the_deadline():
    do = "while time.monotonic() < until: os.write(2, 9000 * b'x')\nsys.exit(5)"
    flood = program(f"until = time.monotonic() + 60\n{do}")
    assert (
        run(flood, deadline=0.3).verdict == "hang"
    )  # a crash if worldgen waited for the end of the flood


def test_an_answer_that_is_there_when_we_look_late_counts(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(
        "sim.controllers.programs.program.time",
        SimpleNamespace(monotonic=lambda: now[0], sleep=time.sleep),
    )

    def send_and_look_late(*order):
        send(*order)
        select.select([late._stdout], [], [], 120.0)
        now[0] += 1000.0

    with ProcessController(program(), deadline=100.0) as controller:
        simulate(arena(), controller, RunOptions(steps=3))
        late = controller._program
        send = late._send
        monkeypatch.setattr(late, "_send", send_and_look_late)
        assert simulate(arena(), controller, RunOptions(steps=3)).verdict == "stalled"


def test_an_answer_in_drips_that_is_there_in_time_counts():
    do = """for char in '{"speed": 0.1, "turn_rate": 0.5}' + chr(10):\n    sys.stdout.write(char); sys.stdout.flush()"""
    assert run(program(do)).verdict in ("stalled", "timeout")


@pytest.mark.gate
@pytest.mark.parametrize(
    ("said", "error"),
    [
        ('{"speed": NaN, "turn_rate": 0}', "speed is not finite"),
        ('{"speed": 0, "turn_rate": -Infinity}', "turn_rate is not finite"),
        ('{"speed": 1e999, "turn_rate": 0}', "speed is not finite"),
        ('{"speed": 1%s, "turn_rate": 0}' % (400 * "0"), "speed is not finite"),
        ('{"speed": 1%s, "turn_rate": 0}' % (9000 * "0"), "not JSON"),
        ('{"speed": "1", "turn_rate": 0}', "speed is not a number"),
        ('{"speed": true, "turn_rate": 0}', "speed is not a number"),
        ('{"speed": 0, "turn_rate": null}', "turn_rate is not a number"),
        ('{"speed": 0}', "no turn_rate"),
        ('{"velocity": 0, "turn_rate": 0}', "no speed"),
        ('{"speed": 0, "turn_rate": 0, "random_used": true}', "unknown key 'random_used'"),
        ('{"speed": 0, "turn_rate": 0, "used_random": 1}', "used_random is neither true nor false"),
        ("[0, 0]", "no object"),
        ("", "not JSON"),
        ("full speed ahead", "not JSON"),
        (60_000 * "[", "not JSON"),
    ],
)
def test_an_answer_that_is_no_command_is_one_verdict(said, error):
    episode = run([*PYTHON, SERVE.replace("AT", "3").replace("DO", "answer(sys.argv[1])"), said])
    assert (episode.verdict, episode.steps, episode.evidence.error) == ("invalid-command", 3, error)
    assert episode.evidence.answer == (said if len(said) <= 200 else f"{said[:200]}...")


def test_binary_garbage_is_no_command():
    episode = run(program(r"os.write(1, bytes(range(256)).replace(b'\n', b'') + b'\n')"))
    assert episode.verdict == "invalid-command" and episode.evidence.answer.isprintable()


def test_a_speed_beyond_the_robots_is_clamped_as_any_controllers():
    fast = program("""answer('{"speed": 9e9, "turn_rate": 0}')""", at=1)
    assert run(fast, steps=2).path_length == pytest.approx(2.0 * 0.015, abs=0.001)


@pytest.mark.parametrize("endless", [False, True])
def test_a_line_without_end_is_no_command_and_takes_no_memory(endless):
    do = (
        "while True: os.write(1, 65536 * b'x')"
        if endless
        else "os.write(1, 65537 * b'x'); time.sleep(60)"
    )
    episode = run(program(do))
    assert (
        episode.evidence.error == "a line of more than 65536 bytes"
        and len(episode.evidence.answer) < 250
    )


def test_two_lines_for_one_observation_are_one_too_many():
    line = r'{"speed": 0, "turn_rate": 0}'
    episode = run(program(f"answer('{line}\\n{line}'); time.sleep(0.05)"))
    assert (episode.verdict, episode.evidence.error) == ("invalid-command", "more than one line")


def test_a_program_that_never_reads_and_talks_all_the_time_ends_as_invalid():
    assert run(["yes", '{"speed": 0, "turn_rate": 0}']).verdict == "invalid-command"


def test_a_program_that_never_reads_hangs_however_long_the_run_is():
    assert run(["sleep", "60"], start_deadline=0.3).verdict == "hang"


@linux
def test_a_program_that_takes_too_much_memory_fails_alone():
    episode = run(program("hog = bytearray(1 << 30)"), memory_limit=256 << 20)
    assert (episode.verdict, episode.evidence.stderr[-1]) == ("crash", "MemoryError")


def test_a_program_that_ignores_sigterm_is_killed(tmp_path):
    (tmp_path / "pid").touch()
    do = f"open({str(tmp_path / 'pid')!r}, 'w').write(str(os.getpid())); time.sleep(60)"
    stubborn = program(do)
    stubborn[-1] = "import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN)" + stubborn[-1]
    assert run(stubborn, deadline=0.2).verdict == "hang"
    assert not is_running((tmp_path / "pid").read_text())


def test_a_grandchild_that_holds_the_pipes_keeps_nobody_and_is_ended(tmp_path):
    note = f"open({str(tmp_path / 'pid')!r}, 'w').write(str(child.pid))"
    do = f"child = subprocess.Popen(['sleep', '3600'])\n{note}\nos._exit(4)"
    episode = run(
        program(do), deadline=120.0
    )  # if it waited for the grandchild, it would be a hang
    assert (episode.evidence.error, episode.evidence.step) == ("exit code 4", 3)
    assert ends((tmp_path / "pid").read_text())


@pytest.mark.gate
def test_a_program_ends_with_this_process_even_if_that_is_killed(tmp_path):
    do = (
        f"open({str(tmp_path / 'pid')!r}, 'w').write(str(os.getpid()))\nanswer('')\nwhile True: "
        f"time.sleep(60)"
    )
    stubborn = program(do, at=1)
    stubborn[-1] = "import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN)" + stubborn[-1]
    code = (
        "import os, sys; from sim.controllers.programs.program import Program; "
        "print(Program(tuple(sys.argv[1:]), None).ask(b'{}\\n', 10.0)); os.kill(os.getpid(), 9)"
    )
    killed = subprocess.run([sys.executable, "-c", code, *stubborn], check=False)
    assert killed.returncode == -signal.SIGKILL and ends((tmp_path / "pid").read_text())


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        (["./no-such-program"], {"code": "program-missing", "program": "./no-such-program"}),
        ([str(BOUNCE_C)], {"code": "not-executable"}),
        ([], {"code": "wrong-type"}),
        ("./mine --flag", {"code": "wrong-type"}),
    ],
)
def test_a_program_that_is_not_there_is_refused_with_the_way_out(command, expected):
    with raises(InvalidParameter, **expected):
        ProcessController(command)


def test_a_file_that_is_no_program_is_refused_when_it_is_started(tmp_path):
    (tmp_path / "garbage").write_bytes(b"\x00\x01\x02")
    (tmp_path / "garbage").chmod(0o755)
    with raises(InvalidParameter, "cannot-start"):
        run([str(tmp_path / "garbage")])


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        ({"deadline": 0.0}, {"code": "out-of-range", "name": "deadline"}),
        ({"start_deadline": float("nan")}, {"code": "out-of-range", "name": "start_deadline"}),
        ({"memory_limit": 1000}, {"code": "out-of-range", "memory_limit": 1000, "least": 1048576}),
    ],
)
def test_limits_out_of_range_are_refused(limits, expected):
    with raises(InvalidParameter, **expected):
        ProcessController(["sh"], **limits)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("cmd:", {"code": "no-program-named", "name": "cmd:"}),
        ("cmd+deadline=0.2", {"code": "not-a-command", "name": "cmd+deadline=0.2"}),
        (
            "cmd+dedline=1:sh",
            {"code": "unknown-name", "name": "cmd+dedline=1:sh", "key": "dedline"},
        ),
        ("cmd+deadline=soon:sh", {"code": "not-a-number", "key": "deadline", "text": "soon"}),
        ("cmd+memory=lots:sh", {"code": "not-a-size", "text": "lots"}),
        ("cmd:sh 'x", {"code": "invalid-quoting", "name": "cmd:sh 'x"}),
    ],
)
def test_a_command_line_that_cannot_be_read_is_refused(name, expected):
    with raises(InvalidParameter, **expected):
        CONTROLLERS.get(name)


def test_a_command_line_is_split_as_a_shell_would_and_carries_its_limits():
    found = CONTROLLERS.get("cmd+deadline=0.2+start=3+memory=512M:sh -c 'a b' c=d,e+f")
    assert found.command == ("sh", "-c", "a b", "c=d,e+f")
    assert (found.limits.deadline, found.limits.start_deadline, found.limits.memory) == (
        0.2,
        3.0,
        512 << 20,
    )
    assert CONTROLLERS.get("cmd+memory=none:sh").limits.memory is None


def test_of_a_command_line_only_what_stands_before_the_colon_varies_the_run():
    scenario = Scenario.parse(
        "cmd+memory=1G+motion=endpoint+time_step=0.03:./mine a+noise --url=x:y+b"
    )
    assert scenario.controller == "cmd+memory=1G:./mine a+noise --url=x:y+b"
    assert (scenario.run.motion, scenario.run.time_step) == ("endpoint", 0.03)
    assert Scenario.parse(scenario.label("swept", 0.015)) == scenario


def heard(tmp_path, steps, world=None):
    """Return the lines that a program gets in two episodes, and how often it was started."""
    log = tmp_path / "log"
    code = SERVE.replace("AT", "0").replace(
        'if "reset"', "open(sys.argv[1], 'a').write(line)\n    if \"reset\""
    )
    with ProcessController(
        [*PYTHON, f"open(__import__('sys').argv[1], 'a').write('start\\n')\n{code}", str(log)]
    ) as one:
        for _ in range(2):
            simulate(world or arena(), one, RunOptions(steps=steps))
    return log.read_text().splitlines()


def test_one_program_serves_many_episodes_and_hears_of_each(tmp_path):
    lines = heard(tmp_path, steps=2)
    reset = '{"worldgen":1,"reset":{"time_step":0.015,"top_speed":2.0,"radius":0.07}}'
    assert [line if "reset" in line or line == "start" else "" for line in lines] == [
        "start",
        *(2 * [reset, "", ""]),
    ]


# What a line has only where there is something to say.
LEFT_OUT = ("neighbours", "goal_heading", "tilt", "tilt_heading")


def test_a_program_is_told_what_a_python_controller_sees_to_the_last_bit(tmp_path):
    class Listens:
        """Records its observations."""

        senses = Observation._fields

        def reset(self):
            self.seen = []
            return ()

        def act(self, observation, memory):
            self.seen.append(observation)
            return Command(0.1, 0.5), memory

    simulate(arena(), listens := Listens(), RunOptions(steps=20))
    told = [json.loads(line) for line in heard(tmp_path, steps=20)[2:22]]
    assert [tuple(line) for line in told] == 20 * [Observation._fields[: -len(LEFT_OUT)]]
    seen = [observation[: -len(LEFT_OUT)] for observation in listens.seen]
    assert [(*list(line.values())[:-1], tuple(line["beams"])) for line in told] == seen


def test_a_program_is_told_the_heading_of_its_goal(tmp_path):
    goal = replace(arena().target, heading=1.25, radius=0.001)
    told = heard(tmp_path, steps=2, world=replace(arena(), target=goal))
    headings = [json.loads(line).get("goal_heading") for line in told[1:]]
    assert headings == 2 * [None, *(2 * [pytest.approx(1.25, abs=math.pi / 65536)])]


def test_after_a_failure_the_next_episode_has_a_program_of_its_own(tmp_path):
    do = f"open({str(tmp_path / 'log')!r}, 'a').write('x')\nsys.exit(1)"
    with ProcessController(program(do)) as controller:
        verdicts = [simulate(arena(), controller, RunOptions(steps=9)).verdict for _ in range(3)]
    assert verdicts == 3 * ["crash"] and (tmp_path / "log").read_text() == "xxx"


def test_a_program_that_serves_one_episode_and_ends_is_started_for_each():
    once = SERVE.replace("AT", "0").replace(
        "step = 0\n        continue", "step += 1000\n        assert step < 2000\n        continue"
    )
    with ProcessController([*PYTHON, once]) as controller:
        assert {simulate(arena(), controller, RunOptions(steps=3)).verdict for _ in range(3)} <= {
            "timeout",
            "stalled",
        }


def test_a_program_that_repeats_itself_for_ever_stalls_for_nothing_is_known_of_its_memory():
    episode = run(program(), steps=2000)
    assert (episode.verdict, episode.steps) == ("stalled", 2000)


def test_randomness_that_was_used_is_fresh_in_the_next_step(tmp_path):
    code = """import json, sys
for line in sys.stdin:
    seen = json.loads(line)
    if "random" in seen:
        print(seen["random"], file=sys.stderr)
        print(json.dumps({"speed": "x" if len(sys.argv) > 9 else 0, "turn_rate": 0, "used_random": True}), flush=True)
        sys.argv.append("")
"""
    drawn = run([*PYTHON, code, *"1234"]).evidence.stderr
    assert len(drawn) == len(set(drawn)) == 5


def test_an_interrupted_run_leaves_no_answer_for_the_next(monkeypatch):
    with ProcessController(program()) as controller:
        simulate(arena(), controller, RunOptions(steps=3))
        running = controller._program
        monkeypatch.setattr(running, "_receive", interrupt)
        with pytest.raises(KeyboardInterrupt):
            simulate(arena(), controller, RunOptions(steps=3))
        assert running.stopped and simulate(arena(), controller, RunOptions(steps=3)).steps == 3


def interrupt(*_):
    raise KeyboardInterrupt


def test_a_program_in_c_drives_as_the_same_rule_in_python(tmp_path):
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("there is no C compiler here (cc, gcc): the protocol is not tried from C")
    built = subprocess.run(
        [compiler, "-O2", "-Wall", "-o", tmp_path / "bounce", BOUNCE_C, "-lm"], check=False
    )
    world, options = generate("trap", 4, size=20), RunOptions(steps=1000)
    with ProcessController([str(tmp_path / "bounce")]) as in_c:
        found = simulate(world, in_c, options, record=True)
    expected = simulate(world, Example(), options, record=True)
    assert (built.returncode, found.verdict) == (0, "reached")
    assert np.array_equal(found.trace.states[:, :4], expected.trace.states[:, :4])


FAULTY = """#!{python} -IS
import json, sys
for line in sys.stdin:
    seen = json.loads(line)
    if "reset" not in seen:
        if seen["bump"]:
            print(f"at {{id(seen)}}", file=sys.stderr)
            {fault}
        print(json.dumps({{"speed": 1.0, "turn_rate": 0.3}}), flush=True)
"""


def faulty(folder, fault, limits=""):
    path = folder / "faulty"
    path.write_text(FAULTY.format(python=sys.executable, fault=fault))
    path.chmod(0o755)
    return f"cmd{limits}:{path}"


@pytest.mark.gate
def test_a_campaign_finds_shrinks_and_replays_the_crash_of_a_program(tmp_path):
    options = (
        "--units",
        1,
        "--examples",
        80,
        "--seed",
        1,
        "--workers",
        1,
        "--out",
        tmp_path / "out",
        "--json",
    )
    result = worldgen(
        "fuzz", "--controller", faulty(tmp_path, "1 / 0"), "--family", "features", *options
    )
    found = {failure["class"]: failure for failure in json.loads(result.out)["failures"]}
    kind = next(iter(found))
    assert result.code == 1 and re.fullmatch(
        "crash-exit-1-ZeroDivisionError-faulty.module-[0-9a-f]{4}", kind
    )
    failure = read_world(Path(found[kind]["file"])).failure
    assert (
        failure.details["one_minimal"]
        and failure.evidence["stderr"][-1] == "ZeroDivisionError: division by zero"
    )
    assert worldgen("replay", tmp_path / "out").code == 0


@pytest.mark.gate
def test_a_hang_is_found_and_replayed(tmp_path):
    controller = faulty(tmp_path, "import time; time.sleep(60)", "+deadline=0.3")
    options = (
        "--units",
        1,
        "--examples",
        8,
        "--seed",
        1,
        "--workers",
        1,
        "--no-shrink",
        "--family",
        "features",
    )
    result = worldgen("fuzz", "--controller", controller, *options, "--out", tmp_path / "out")
    assert result.code == 1 and (tmp_path / "out" / "hang.grid").exists()
    replayed = worldgen("replay", tmp_path / "out" / "hang.grid")
    assert replayed.code == 0 and "the same, bit for bit: hang in step " in replayed.out


def test_a_replay_without_the_program_says_what_is_missing(tmp_path):
    options = (
        "--units",
        1,
        "--examples",
        8,
        "--seed",
        1,
        "--workers",
        1,
        "--no-shrink",
        "--family",
        "features",
    )
    assert (
        worldgen(
            "fuzz", "--controller", faulty(tmp_path, "1 / 0"), *options, "--out", tmp_path / "out"
        ).code
        == 1
    )
    (tmp_path / "faulty").unlink()
    CONTROLLERS._loaded.clear()
    result = worldgen("replay", tmp_path / "out")
    assert result.code == 1 and "does not exist" in result.out and "Traceback" not in result.err


def test_a_program_that_never_answers_is_told_before_the_search(tmp_path):
    words = ("--controller", "cmd+start=0.2:sleep 60", "--seed", 1, "--out", tmp_path / "out")
    result = worldgen("fuzz", *words)
    assert result.code == 2 and "does it flush its output after each line?" in result.err


@pytest.mark.nightly
def test_ctrl_c_in_a_campaign_leaves_no_program(tmp_path):
    note = f"open({str(tmp_path / 'pids')!r}, 'a').write(str(__import__('os').getpid()) + chr(10))"
    command = [
        sys.executable,
        "-c",
        "from worldgen.cli.main import main; main()",
        "fuzz",
        "--workers",
        "2",
    ]
    options = [
        "--controller",
        faulty(tmp_path, note),
        "--budget",
        "10m",
        "--out",
        str(tmp_path / "out"),
    ]
    with subprocess.Popen([*command, *options], stderr=subprocess.PIPE) as campaign:
        try:
            assert waits_for(
                lambda: len(pids(tmp_path)) >= 3, 180
            )  # the process of the first try, and the workers'
        finally:
            campaign.send_signal(signal.SIGINT)
            campaign.communicate(timeout=180)
    assert campaign.returncode == 130 and all(ends(process_id) for process_id in pids(tmp_path))


def pids(folder):
    return set((folder / "pids").read_text().split()) if (folder / "pids").exists() else set()
