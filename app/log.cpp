#include "app/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <memory>

namespace vsfind {
namespace {

int verbose = 0;
bool quiet = false;

}  // namespace

void add_log_options(CLI::App& app) {
  app.add_flag("-v,--verbose", verbose, "Say more on stderr; twice: say everything");
  app.add_flag("-q,--quiet", quiet, "Only errors on stderr: no warnings, progress or summary");
}

void apply_log_options() {
  auto logger = std::make_shared<spdlog::logger>("vsfind", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  logger->set_pattern("vsfind: %^%l%$: %v");
  logger->set_level(quiet          ? spdlog::level::err
                    : verbose == 0 ? spdlog::level::warn
                    : verbose == 1 ? spdlog::level::info
                                   : spdlog::level::debug);
  spdlog::set_default_logger(std::move(logger));
}

bool log_is_quiet() { return quiet; }

}  // namespace vsfind
