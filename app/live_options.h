#pragma once
/// @file
/// What `live` is asked to do: sources, each with its own patterns, calibration and camera settings, and one output.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/camera.h"
#include "app/config.h"
#include "app/row_file.h"
#include "app/run_options.h"

namespace vsfind {

/// One source, and how it is searched.
struct LiveSource {
  std::string uri;
  RunOptions options;
  CameraSettings camera;
  std::string record;  ///< file for what is searched, "" for none
};

struct LiveRequest {
  std::string config;
  std::vector<std::string> uris;    ///< sources that share all settings
  LiveSource common;                ///< those settings; of its options, csv, jsonl, overlay and report are for all
  std::vector<LiveSource> sources;  ///< what is done, after complete_live_request()
  std::optional<std::uint64_t> frames;
  std::optional<double> seconds;
  std::optional<double> give_up_after;  ///< seconds
  RowFileOptions row_files;
};

/// All settings, for the command line and the top level of a configuration. `request` must outlive them.
[[nodiscard]] std::vector<Setting> live_settings(LiveRequest& request);

/// Fills the request from its configuration, where one is named (`request.config`), and then from the command line,
/// whose `settings` are those of live_settings() for this request. A configuration lists sources with settings of their
/// own under `sources:`; what stands beside it is for all of them. Throws UsageError, IoError.
void complete_live_request(LiveRequest& request, const Settings& settings);

/// The part of that which a configuration alone does, for tests and the examples.
void apply_live_config(LiveRequest& request, const std::vector<Setting>& settings);

}  // namespace vsfind
