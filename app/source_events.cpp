#include "app/source_events.h"

#include <spdlog/spdlog.h>

namespace vsfind {

void log_source_events(FrameSource& source) {
  source.on_event([](const SourceEvent& event) {
    const bool note = event.kind == SourceEvent::Kind::note;
    spdlog::log(note ? spdlog::level::info : spdlog::level::warn, "{}", event.text);
  });
}

}  // namespace vsfind
