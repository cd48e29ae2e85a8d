// Remarks of a teacher on a session, in a file beside the recording, which they leave as it is.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/json.h"

namespace typodont::session {

struct Remark {
  std::string author, written;  // written: ISO 8601, UTC
  std::string text;
  std::optional<double> at;  // s, moment of the recording
};

/// SESSION.h5.remarks.json
std::filesystem::path remarks_beside(const std::filesystem::path& recording);
/// {"remarks": [{"author", "written", "text", "at_s"}…]}. Throws Error.
std::vector<Remark> remarks_from(const Json& json);
/// Empty without the file. Throws Error.
std::vector<Remark> read_remarks(const std::filesystem::path& recording);
/// The remarks as JSON text, which remarks_from() reads.
std::string remarks_text(const std::vector<Remark>& remarks);
/// Without remarks, removes the file. Throws Error.
void write_remarks(const std::filesystem::path& recording, const std::vector<Remark>& remarks);

}  // namespace typodont::session
