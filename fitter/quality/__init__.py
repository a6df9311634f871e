"""What measured data suffer from, found before a fit: one sentence each, with a count and what to do."""

from .finding import Finding as Finding
from .rules import inspect as inspect
from .rules import reorder_channels as reorder_channels
