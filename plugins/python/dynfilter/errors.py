# SPDX-License-Identifier: MIT
"""What dynfilter raises on purpose. Every message is one line that can be shown to a user."""


class Error(RuntimeError):
    """Base of the errors below."""


class ConfigError(Error, ValueError):
    """A configuration that cannot be used. `path` is its place in the YAML, such as `pipeline.before_pose[0]`."""

    path: str = ""


class IoError(Error, OSError):
    """A file or folder that cannot be read or written."""


class PluginError(Error):
    """A plugin that cannot be loaded."""
