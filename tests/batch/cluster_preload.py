"""Loaded by the workers of the cluster of tests: their worker processes are faulty ones."""

from __future__ import annotations

from splinebba_cli.batch import worker_process
from tests.batch.faulty_worker import start_code


def dask_setup(worker: object) -> None:
    worker_process._START = start_code()
