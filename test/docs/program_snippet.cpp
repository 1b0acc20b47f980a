// SPDX-License-Identifier: MIT
#include "first_pipeline_1.inc"
