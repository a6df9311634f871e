"""Fits of many measurements, one process per core.

    for outcome in fitter.fit_many(["gold.binary", "chrome.binary"], "lambert+ggx", output="fits"):
        print(outcome.name, outcome.sentence)

Each process reads, fits and writes for itself: a measurement that fails, or that takes its process with it, stops no
other, and what is finished is on disk. A second call with the same options goes on where the first one ended.

Processes are spawned: a script that calls this guards its own start with `if __name__ == "__main__":`.
"""

from __future__ import annotations

import concurrent.futures
import contextlib
import dataclasses
import json
import multiprocessing
import os
import pathlib
import signal
import threading
from collections.abc import Generator, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from brdf.errors import UserError
from brdf.material import load_material

from .formats import split_member

# What a job's provenance says of how it was fitted; a material with another one is not its result.
_KEY = "fit_options"
_CONVERGED = "converged"


@dataclasses.dataclass(frozen=True)
class Outcome:
    """How one of many fits ended.

    - `source`, `name`: the measurement as it was named, and the stem of its material's file.
    - `path`: the material that was written, or None.
    - `kind`: `"fitted"`, `"kept"` (an earlier run had fitted it), `"not converged"` or `"failed"`.
    - `errors`: as of the fit's result; empty if it failed.
    - `sentence`: its status, or what went wrong.
    - `seconds`: of the whole job.
    """

    source: str
    name: str
    path: str | None
    kind: str
    errors: Mapping[str, float]
    sentence: str
    seconds: float

    @property
    def is_good(self) -> bool:
        return self.kind in ("fitted", "kept")


@dataclasses.dataclass(frozen=True)
class _Job:
    source: str
    name: str
    path: str
    model: str
    read_options: Mapping[str, str]
    options: Mapping[str, Any]
    force: bool

    @property
    def key(self) -> str:
        """All that decides about the result but the measurement."""
        return json.dumps([self.model, dict(self.read_options), dict(self.options)], sort_keys=True, default=str)


def fit_many(
    sources: Sequence[str | os.PathLike[str]],
    model: str,
    *,
    output: str | os.PathLike[str],
    read_options: Mapping[str, str] | None = None,
    workers: int | None = None,
    force: bool = False,
    cache: str | None = None,
    **options: Any,
) -> Iterator[Outcome]:
    """Fits a model to each of many measurements and writes their materials.

    **Arguments:**

    - `sources`: measurement files; `slices.npz:*` stands for all members of an npz.
    - `model`: an expression, or `"auto"` or several expressions with commas between them (see `fitter.select`).
    - `output`: the folder for the materials, `NAME.json` each; it is made if need be.
    - `read_options`: of the reader, as for `fitter.read`.
    - `workers`: how many processes; by default one per core.
    - `force`: fits those again whose material exists.
    - `cache`: folder for compiled programs, shared by the processes.
    - `options`: as for `fitter.fit`.

    **Returns:** an iterator over the outcomes as they come.

    **Raises:** `UserError` if there is nothing to fit, or two measurements would write the same file.
    """
    folder = pathlib.Path(output)
    jobs = [
        _Job(source, name, str(folder / f"{name}.json"), model, read_options or {}, options, force)
        for source, name in _named(sources)
    ]
    folder.mkdir(parents=True, exist_ok=True)
    return _run(jobs, workers or _cores(), cache)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _named(sources: Sequence[str | os.PathLike[str]]) -> list[tuple[str, str]]:
    """The measurements and the names of their materials."""
    found: list[tuple[str, str]] = []
    for given in sources:
        source = os.fspath(given)
        file, member = split_member(source)
        if member == "*":
            from .formats.slices import members

            found += [(f"{file}:{one}", one) for one in members(file)]
        else:
            found.append((source, member or file.stem))
    if not found:
        raise UserError("There is no measurement to fit. Name one file or more.")
    names: dict[str, str] = {}
    for source, name in found:
        if name in names:
            raise UserError(f"`{names[name]}` and `{source}` would both write `{name}.json`. Rename one of them.")
        names[name] = source
    return found


def _run(jobs: Sequence[_Job], workers: int, cache: str | None) -> Iterator[Outcome]:
    open_jobs = []
    for job in jobs:
        kept = _kept(job)
        if kept is None:
            open_jobs.append(job)
        else:
            yield kept
    suspects: list[_Job] = []
    while open_jobs or suspects:
        # What may have killed its process runs alone: nothing else is lost with it, and it has all memory.
        alone, suspects = suspects[:1], suspects[1:]
        left = yield from _side_by_side(alone or open_jobs, workers, cache)
        if not alone:
            # Jobs begin in order: those that were under way, or about to be, are the first ones left.
            suspects, open_jobs = left[: workers + 1], left[workers + 1 :]
        elif left:
            sentence = "Its process died: it may need more memory than there is."
            yield Outcome(left[0].source, left[0].name, None, "failed", {}, sentence, 0.0)


def _side_by_side(jobs: Sequence[_Job], workers: int, cache: str | None) -> Generator[Outcome, None, list[_Job]]:
    """Yields outcomes as they come; returns the jobs, in order, that had none when a process died."""
    lost: set[str] = set()
    context = multiprocessing.get_context("spawn")
    # Its processes read from one end, and end themselves when the other is closed, by us or by our death.
    watched, held = context.Pipe(duplex=False)
    with (
        watched,
        held,
        concurrent.futures.ProcessPoolExecutor(
            min(workers, len(jobs)), context, _begin, (cache, workers > 1, watched)
        ) as pool,
    ):
        try:
            futures = {pool.submit(_fit_one, job): job for job in jobs}
            for future in concurrent.futures.as_completed(futures):
                try:
                    yield future.result()
                except BrokenProcessPool:
                    # A process that dies breaks its pool, and all that had not ended ends with it.
                    lost.add(futures[future].path)
        except BaseException:
            # Interrupted, or nobody asks for the rest: what is being fitted is not waited for.
            held.close()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [job for job in jobs if job.path in lost]


def _kept(job: _Job) -> Outcome | None:
    """The outcome of an earlier run, if its material is there."""
    path = pathlib.Path(job.path)
    if job.force or not path.exists():
        return None
    try:
        provenance = load_material(path).provenance
    except UserError as error:
        return Outcome(job.source, job.name, None, "failed", {}, f"{error} Use --force to replace it.", 0.0)
    if provenance.get(_KEY) != job.key:
        sentence = f"{job.path} exists and was made with other options. Use --force to replace it."
        return Outcome(job.source, job.name, None, "failed", {}, sentence, 0.0)
    kind = "kept" if provenance.get(_CONVERGED) else "not converged"
    status = str(provenance.get("status", ""))
    return Outcome(job.source, job.name, job.path, kind, provenance.get("errors", {}), status, 0.0)


def _begin(cache: str | None, pinned: bool, watched: Any) -> None:
    """Prepares a process: it ends when its parent wants it to, and has its own core and the common cache."""
    # An interrupt from the keyboard reaches all processes at once; the parent alone answers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(watched,), daemon=True).start()
    if pinned and hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        place = multiprocessing.current_process()._identity[-1] - 1
        os.sched_setaffinity(0, {cores[place % len(cores)]})
    if cache:
        import jax

        jax.config.update("jax_compilation_cache_dir", cache)


def _end_with(watched: Any) -> None:
    with contextlib.suppress(EOFError, OSError):
        watched.recv_bytes()
    os._exit(1)


def _fit_one(job: _Job) -> Outcome:
    import time

    from brdf.material import Material, save_material

    from .fitting import fit
    from .formats import read
    from .select import AUTO, select

    started = time.perf_counter()

    def outcome(kind: str, sentence: str, errors: Mapping[str, float], path: str | None = None) -> Outcome:
        return Outcome(job.source, job.name, path, kind, errors, sentence, time.perf_counter() - started)

    try:
        data = read(job.source, job.read_options)
        if job.model == AUTO or "," in job.model:
            models = AUTO if job.model == AUTO else job.model.split(",")
            result = select(data, models, **job.options).result
        else:
            result = fit(job.model, data, **job.options)
        material = Material(result.brdf, {**result.material.provenance, _KEY: job.key, _CONVERGED: result.converged})
        save_material(material, job.path, force=True)
    except UserError as error:
        return outcome("failed", str(error), {})
    except Exception as error:
        # One measurement's unforeseen trouble is no reason to lose the others.
        return outcome("failed", f"{type(error).__name__}: {error}", {})
    kind = "fitted" if result.converged else "not converged"
    return outcome(kind, result.status, result.errors, job.path)
