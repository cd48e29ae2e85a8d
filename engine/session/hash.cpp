#include "engine/session/hash.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/sha256.h"

namespace typodont::session {

std::string to_text(const Fnv1a& hash) {
  return fmt::format("fnv1a64:{:016x}", hash.value);
}

void add_forces(Fnv1a& hash, std::span<const ServoTick> ticks) noexcept {
  for (const ServoTick& tick : ticks) {
    for (const dvec3& v : {tick.f_T_W, tick.tau_T_W}) {
      hash.add(v.x);
      hash.add(v.y);
      hash.add(v.z);
    }
  }
}

SourceFile describe_file(const std::filesystem::path& file, std::ostream* copy) {
  std::ifstream in = open_input(file, InputKind::kAny);
  SourceFile result;
  result.path = file.filename().string();
  Sha256 hash;
  std::array<char, 1 << 16> buffer;
  while (in) {
    in.read(buffer.data(), buffer.size());
    const std::streamsize size = in.gcount();
    hash.bytes(buffer.data(), static_cast<std::size_t>(size));
    if (copy && !copy->write(buffer.data(), size))
      throw Error("copy of " + file.string(), "", std::strerror(errno), "free space in the folder for temporary files");
    result.bytes += static_cast<std::uint64_t>(size);
  }
  if (in.bad()) throw Error(file.string(), "", std::strerror(errno), "a readable file");
  result.hash = hash.text();
  return result;
}

}  // namespace typodont::session
