# SPDX-License-Identifier: MIT
"""Where the package's own files are."""

import os

pipelines_folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "pipelines")
