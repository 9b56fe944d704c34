"""Commands called in process; what one prints keeps the house rules, and every USD file that it writes is validated."""

import json
import os
from pathlib import Path

import pytest
from composed import new_errors
from house_rules import broken_rules

from usd_tools import (
    compare,
    demo,
    downsample,
    from_bvh,
    inspect,
    learn,
    live,
    metric,
    pack,
    repair,
    resample,
    study,
    to_bvh,
    unpack,
    upsample,
)

USD = (".usd", ".usda", ".usdc", ".usdz")


@pytest.fixture
def run(request, capsys):
    """Call a verb in process; give its exit code, stdout and stderr.

    What it prints must keep the house's rules. What it writes must have no error for OpenUSD's validators that its
    input has not; the marker `invalid_output` says why a test's output may.
    """
    is_validated = request.node.get_closest_marker("invalid_output") is None

    modules = (
        demo,
        upsample,
        downsample,
        inspect,
        learn,
        compare,
        from_bvh,
        live,
        metric,
        repair,
        resample,
        study,
        to_bvh,
        pack,
        unpack,
    )
    verbs = {module.__name__.rpartition(".")[2]: module for module in modules}

    def call(verb, *arguments):
        main = verbs[verb].main
        validate = _validation([str(argument) for argument in arguments]) if is_validated else None
        capsys.readouterr()
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as stop:
            code = stop.code
        out, err = capsys.readouterr()
        if code == 0 and validate is not None:
            assert validate() == {}
        assert broken_rules(err) == []
        assert {"--json", "--csv"} & set(map(str, arguments)) or broken_rules(out) == []
        return code, out, err

    return call


def _validation(arguments):
    """Remember what is wrong with the inputs; give what tells, afterwards, the new errors of each output."""
    options = [word for word in ("-o", "--out") if word in arguments]
    out = Path(arguments[arguments.index(options[0]) + 1]) if options else None
    named = [Path(word) for word in arguments if Path(word) != out or "--in-place" in arguments]
    # os.path, since a word that is no path (a number of 400 digits) is an error for pathlib on some file systems
    inputs = [path for folder in named if os.path.isdir(folder) for path in sorted(folder.rglob("*"))]
    inputs = [path for path in (*named, *inputs) if path.suffix.lower() in USD and os.path.isfile(path)]
    if "--in-place" in arguments:
        out = out or inputs[0]
    if out is None or "--dry-run" in arguments:
        return None
    is_new = new_errors(inputs, now="--in-place" in arguments)

    def validate():
        written = [path for path in out.rglob("*") if path.suffix in USD] if out.is_dir() else [out]
        found = {path.name: is_new(path) for path in written if path.suffix in USD}
        return {name: errors for name, errors in found.items() if errors}

    return validate


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
