#include <glib.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <string>

#include "acquisition/gige_source.h"

namespace vsfind {
namespace {

void log_line(const gchar* domain, GLogLevelFlags level, const gchar* message, gpointer /*data*/) {
  std::string text = message != nullptr ? message : "";
  std::replace(text.begin(), text.end(), '\n', ' ');
  const bool fatal = (level & (G_LOG_LEVEL_ERROR | G_LOG_FLAG_FATAL)) != 0;
  spdlog::log(fatal ? spdlog::level::err : spdlog::level::info, "camera library: {}: {}",
              domain != nullptr ? domain : "GLib", text);
}

}  // namespace

void log_gige_library() { g_log_set_default_handler(log_line, nullptr); }

}  // namespace vsfind
