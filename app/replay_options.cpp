#include "app/replay_options.h"

namespace vsfind {

std::vector<Setting> replay_settings(ReplayRequest& request) {
  ReplayRequest* const r = &request;
  Setting source{"source", "SEQUENCE", "Recording (.y4m), or folder of images in name order",
                 [r](const std::vector<std::string>& v) { r->source = parse_path(v[0]); }};
  source.positional = true;
  source.path = true;
  std::vector<Setting> settings{source};
  for (auto& setting : run_settings(request.options,
                                    "What is searched of every frame: frame: all lines; top, bottom: that field only; "
                                    "split: both fields, the earlier one first, a row each. Frames recorded as single "
                                    "fields are searched as such (default frame)")) {
    settings.push_back(std::move(setting));
  }
  return settings;
}

}  // namespace vsfind
