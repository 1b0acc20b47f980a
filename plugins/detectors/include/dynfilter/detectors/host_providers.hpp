// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/detectors/file_provider.hpp>
#include <dynfilter/detectors/process_provider.hpp>
#include <dynfilter/semantic/provider_registry.hpp>

#ifdef DYNFILTER_HAS_DNN
#include <dynfilter/detectors/dnn_provider.hpp>
#endif

namespace dynfilter {

/// The kinds of detector that a host's settings may name: files and processes, and networks of OpenCV where
/// the host links dynfilter::dnn. Hand it to OrbSlam or MaskedHost.
inline ProviderRegistry host_providers() {
  ProviderRegistry registry;
  registry.add<FileProvider>();
  registry.add<ProcessProvider>();
#ifdef DYNFILTER_HAS_DNN
  registry.add<DnnProvider>();
#endif
  return registry;
}

}  // namespace dynfilter
