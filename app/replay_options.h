#pragma once
/// @file
/// What `replay` is asked to do.

#include <string>
#include <vector>

#include "app/run_options.h"

namespace vsfind {

struct ReplayRequest {
  std::string source;
  std::string config;
  RunOptions options;
};

/// The settings that fill `request`, which must outlive them: those of the command line and of a configuration.
[[nodiscard]] std::vector<Setting> replay_settings(ReplayRequest& request);

}  // namespace vsfind
