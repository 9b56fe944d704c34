"""Commands called in process."""

import json

import pytest

from usd_tools import compare, downsample, from_bvh, inspect, learn, upsample


@pytest.fixture
def run(capsys):
    """Call a verb in process; give its exit code, stdout and stderr."""

    modules = (upsample, downsample, inspect, learn, compare, from_bvh)
    verbs = {module.__name__.rpartition(".")[2]: module for module in modules}

    def call(verb, *arguments):
        main = verbs[verb].main
        capsys.readouterr()
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as stop:
            code = stop.code
        out, err = capsys.readouterr()
        return code, out, err

    return call


@pytest.fixture
def inspected(run):
    """Call inspect --json and parse what it prints."""

    def call(path):
        code, out, _ = run("inspect", path, "--json")
        assert code == 0
        return json.loads(out)

    return call


@pytest.fixture
def refuse(tmp_path, run):
    """Run a verb and check that it refuses politely; give the sentence."""

    def call(verb, *arguments, exit_code=1):
        before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        code, out, err = run(verb, *arguments)
        assert code == exit_code
        assert "Traceback" not in out + err
        assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
        if exit_code == 1:
            assert err.splitlines()[-1].startswith("error: ")
            assert err.count("error: ") == 1
        line = err.splitlines()[0 if exit_code == 2 else -1]  # the usage follows a usage error
        return line.split("error: ", 1)[1].replace(f"{tmp_path}/", "")

    return call
