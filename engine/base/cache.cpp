#include "engine/base/cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <utility>
#include <vector>

#include "engine/base/build_identity.h"
#include "engine/base/log.h"

namespace typodont::cache {

namespace fs = std::filesystem;

fs::path folder() {
  const auto named = [](const char* variable) { return fs::path(std::getenv(variable) ? std::getenv(variable) : ""); };
  if (const fs::path own = named("TYPODONT_CACHE"); !own.empty()) return own;
  if (const fs::path users = named("XDG_CACHE_HOME"); users.is_absolute()) return users / "typodont";
  if (const fs::path home = named("HOME"); home.is_absolute()) return home / ".cache/typodont";
  return {};
}

fs::path folder(const std::string& name) {
  const fs::path all = folder();
  return all.empty() ? all : all / name;
}

std::optional<std::uint64_t> hash_of(const fs::path& file) {
  std::error_code code;
  // Only regular files: reading a device may never end.
  if (!fs::is_regular_file(file, code)) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  Sha256 hash;
  std::array<char, 1 << 16> piece;  // on the stack, because allocating it for many small files takes time
  while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())), in.gcount() > 0)
    hash.bytes(piece.data(), static_cast<std::size_t>(in.gcount()));
  if (in.bad()) return std::nullopt;
  return hash.key();
}

void add_build(Sha256& key) {
  key.add(build_identity());
}

bool add_file(Sha256& key, const fs::path& file) {
  std::error_code code;
  const auto size = fs::file_size(file, code);
  if (code) return false;
  const auto written = fs::last_write_time(file, code).time_since_epoch().count();
  if (code) return false;
  const std::string name = fs::absolute(file, code).string();
  key.bytes(name.data(), name.size());
  key.add(size);
  key.add(written);
  return true;
}

namespace {

/// Name of a cached file: "KEY-CONTENT.suffix". CONTENT is a hash of the file's bytes, which reveals damage.
std::string name_of(std::uint64_t key, std::uint64_t content, const std::string& suffix) {
  return fmt::format("{:016x}-{:016x}{}", key, content, suffix);
}

std::vector<fs::path> files_in(const fs::path& in) {
  std::vector<fs::path> files;
  std::error_code code;
  for (fs::directory_iterator it(in, code), end; !code && it != end; it.increment(code)) files.push_back(it->path());
  return files;
}

void trim(const fs::path& in, std::uintmax_t most) {
  std::error_code code;
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::uintmax_t all = 0;
  for (const fs::path& file : files_in(in)) {
    const auto size = fs::file_size(file, code);
    if (code) continue;
    all += size;
    files.emplace_back(fs::last_write_time(file, code), file);
  }
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i + 1 < files.size() && all > most; ++i) {
    const auto size = fs::file_size(files[i].second, code);
    if (!code && fs::remove(files[i].second, code)) all -= size;
  }
}

}  // namespace

fs::path find(const fs::path& in, std::uint64_t key, const std::string& suffix) {
  std::error_code code;
  const std::string begins = fmt::format("{:016x}-", key);
  for (const fs::path& file : files_in(in)) {
    const std::string name = file.filename().string();
    if (!name.starts_with(begins) || !name.ends_with(suffix)) continue;
    const auto content = hash_of(file);
    if (content && name == name_of(key, *content, suffix)) {
      // Records the last use: keep() removes the least recently used.
      fs::last_write_time(file, fs::file_time_type::clock::now(), code);
      return file;
    }
    log::info("{} is damaged and is created again", file.string());
    fs::remove(file, code);
  }
  return {};
}

bool keep(const fs::path& in, std::uint64_t key, const std::string& suffix, std::uintmax_t most,
          const std::function<void(const fs::path&)>& write) {
  if (in.empty()) return false;
  std::error_code code;
  fs::create_directories(in, code);
  const fs::path part = in / fmt::format("part-{}{}", ::getpid(), suffix);
  try {
    write(part);
  } catch (const std::exception&) {
    fs::remove(part, code);
    return false;
  }
  const auto content = hash_of(part);
  if (content) fs::rename(part, in / name_of(key, *content, suffix), code);
  if (!content || code) {
    fs::remove(part, code);
    return false;
  }
  trim(in, most);
  return true;
}

}  // namespace typodont::cache
