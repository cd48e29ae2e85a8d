// Remarks of a teacher on a session, in a file beside the recording. The recording itself does not change.
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
  std::optional<double> at;  // s, moment of the recording to which the remark belongs
};

/// Path of a recording's remarks: SESSION.h5.remarks.json.
std::filesystem::path remarks_beside(const std::filesystem::path& recording);
/// Reads {"remarks": [{"author", "written", "text", "at_s"}…]}. Throws Error.
std::vector<Remark> remarks_from(const Json& json);
/// Reads a recording's remarks; empty if there is no such file. Throws Error.
std::vector<Remark> read_remarks(const std::filesystem::path& recording);
/// The remarks as JSON text, which remarks_from() reads.
std::string remarks_text(const std::vector<Remark>& remarks);
/// Writes the remarks; removes the file if there are none. Throws Error.
void write_remarks(const std::filesystem::path& recording, const std::vector<Remark>& remarks);

}  // namespace typodont::session
