// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/cluster_expand.hpp>
#include <dynfilter/pipeline/depth_layers.hpp>
#include <dynfilter/pipeline/logic_stages.hpp>
#include <dynfilter/pipeline/object_vote.hpp>
#include <dynfilter/pipeline/routing_stages.hpp>
#include <dynfilter/pipeline/temporal_stage.hpp>
#include <dynfilter/pipeline/vote_stage.hpp>
