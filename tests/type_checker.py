"""The run-time checker of shapes and types that the tests switch on: an `int` passes as a `float`."""

from beartype import BeartypeConf, beartype

check = beartype(conf=BeartypeConf(is_pep484_tower=True))
