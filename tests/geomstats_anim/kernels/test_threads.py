import numpy as np
import pytest

from geomstats_anim.kernels import threads


@pytest.mark.parametrize("n_processors", [1, 2, 5])
@pytest.mark.parametrize("n_problems", [0, 1, 511, 1024, 5000])
def test_threads_share_out_every_problem_once(monkeypatch, n_processors, n_problems):
    monkeypatch.setattr(threads.os, "sched_getaffinity", lambda _: set(range(n_processors)), raising=False)
    seen = np.zeros(n_problems, dtype=int)

    def run(part):
        seen[part] += 1

    threads.in_threads(run, n_problems)
    assert (seen == 1).all()


def test_an_error_in_a_thread_is_raised(monkeypatch):
    monkeypatch.setattr(threads.os, "sched_getaffinity", lambda _: {0, 1}, raising=False)

    def run(part):
        raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match="broken"):
        threads.in_threads(run, 5000)


def test_parts_are_not_cut_again(monkeypatch):
    monkeypatch.setattr(threads.os, "sched_getaffinity", lambda _: {0, 1}, raising=False)
    seen, sizes = np.zeros(5000, dtype=int), []

    def run(part):
        def inner(part_of_it):
            sizes.append(part_of_it.stop - part_of_it.start)
            seen[part][part_of_it] += 1

        threads.in_threads(inner, part.stop - part.start)
        assert sizes[-1] == part.stop - part.start

    threads.in_threads(run, 5000, least=1200)
    assert (seen == 1).all() and sorted(sizes) == [1250] * 4
