#include <nlohmann/json.hpp>

#include "app/row_writer.h"

namespace vsfind {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::string as_utf8(const std::string& text) {
  return Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace)).get<std::string>();
}

void JsonlWriter::write(const ResultRow& row) {
  Json object = Json::object();
  for (const auto& cell : row_cells(row)) {
    if (cell.text.empty()) {
      object[cell.column] = nullptr;
    } else if (cell.kind == RowCell::Kind::text) {
      object[cell.column] = cell.text;
    } else if (cell.kind == RowCell::Kind::flag) {
      object[cell.column] = cell.text == "1";
    } else {
      object[cell.column] = Json::parse(cell.text);  // the very digits of the CSV
    }
  }
  file_.write_line(object.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace vsfind
