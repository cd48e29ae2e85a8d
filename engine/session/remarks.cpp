#include "engine/session/remarks.h"

#include <nlohmann/json.hpp>

#include "engine/base/error.h"
#include "engine/base/partial_file.h"

namespace typodont::session {

namespace fs = std::filesystem;

namespace {
constexpr std::size_t kMaxText = 4000;  // bytes, longest text of a remark
constexpr double kLongest = 86'400;     // s, largest recording time that a remark may state
}  // namespace

fs::path remarks_beside(const fs::path& recording) {
  fs::path file = recording;
  file += ".remarks.json";
  return file;
}

std::vector<Remark> remarks_from(const Json& json) {
  json.allow_only({"remarks"});
  std::vector<Remark> remarks;
  for (const Json& one : json["remarks"].items()) {
    one.allow_only({"author", "written", "text", "at_s"});
    Remark remark{one.string_or("author", ""), one.string_or("written", ""), one["text"].string(), {}};
    if (remark.text.empty() || remark.text.size() > kMaxText) one["text"].fail("1 to 4000 bytes");
    if (one.has("at_s")) remark.at = one["at_s"].number(0, kLongest);
    remarks.push_back(std::move(remark));
  }
  return remarks;
}

std::vector<Remark> read_remarks(const fs::path& recording) {
  const fs::path file = remarks_beside(recording);
  std::error_code code;
  return fs::exists(file, code) ? remarks_from(Json::load(file)) : std::vector<Remark>();
}

std::string remarks_text(const std::vector<Remark>& remarks) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Remark& remark : remarks) {
    list.push_back({{"author", remark.author}, {"written", remark.written}, {"text", remark.text}});
    if (remark.at) list.back()["at_s"] = *remark.at;
  }
  return nlohmann::ordered_json{{"remarks", list}}.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

void write_remarks(const fs::path& recording, const std::vector<Remark>& remarks) {
  const fs::path file = remarks_beside(recording);
  if (remarks.empty()) {
    std::error_code code;
    if (fs::remove(file, code); code) throw Error(file.string(), "", code.message(), "a file that can be removed");
    return;
  }
  write_file_atomically(file, remarks_text(remarks), FileKind::kJson, Over::kItsInput);
}

}  // namespace typodont::session
