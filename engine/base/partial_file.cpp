#include "engine/base/partial_file.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/sync.h"

namespace typodont {

namespace {

bool is_gone(pid_t process) {
  return kill(process, 0) != 0 && errno == ESRCH;
}

/// The process in "PREFIX123SUFFIX"; 0 where the name is another.
pid_t process_in(std::string_view name, std::string_view prefix, std::string_view suffix) {
  if (!name.starts_with(prefix) || !name.ends_with(suffix) || name.size() <= prefix.size() + suffix.size()) return 0;
  name.remove_prefix(prefix.size());
  name.remove_suffix(suffix.size());
  pid_t process = 0;
  const auto [end, code] = std::from_chars(name.data(), name.data() + name.size(), process);
  return code == std::errc{} && end == name.data() + name.size() && process > 0 ? process : 0;
}

void remove_what_the_dead_left(const std::filesystem::path& file, std::string_view suffix) {
  const std::string prefix = file.filename().string() + ".";
  std::error_code code;
  std::filesystem::directory_iterator entry(file.has_parent_path() ? file.parent_path() : ".", code);
  for (; !code && entry != std::filesystem::directory_iterator(); entry.increment(code)) {
    const pid_t process = process_in(entry->path().filename().string(), prefix, suffix);
    std::error_code ignored;
    if (process != 0 && is_gone(process)) std::filesystem::remove(entry->path(), ignored);
  }
}

}  // namespace

PartialFile::PartialFile(std::filesystem::path file, std::string_view kind) : file_(std::move(file)) {
  std::error_code code;
  if (std::filesystem::is_directory(file_, code)) throw Error(file_.string(), "", "a directory", "a file to write");
  const std::string suffix = kind.empty() ? ".partial" : fmt::format(".{}.partial", kind);
  remove_what_the_dead_left(file_, suffix);
  path_ = fmt::format("{}.{}{}", file_.string(), getpid(), suffix);
}

PartialFile::~PartialFile() {
  std::error_code code;
  if (!path_.empty()) std::filesystem::remove(path_, code);
}

void PartialFile::keep() {
  // Its content before its name, so that a power cut leaves the old file or the new one, whole.
  if (!sync_file(path_)) throw Error(file_.string(), "", std::strerror(errno), "a place that keeps what is written");
  std::error_code code;
  std::filesystem::rename(path_, file_, code);
  if (code) throw Error(file_.string(), "", code.message(), "a writable place");
  path_.clear();
  sync_folder_of(file_);
}

}  // namespace typodont
