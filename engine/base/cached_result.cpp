#include "engine/base/cached_result.h"

#include <zlib.h>

#include "engine/base/error.h"

namespace typodont::cache {

Parts::Parts(const std::filesystem::path& file, const char* mode)
    : file_(gzopen(file.c_str(), mode),
            [](void* open) {
              if (open) gzclose(static_cast<gzFile>(open));
            }),
      reads_(*mode == 'r') {
  if (!file_) return;
  gzbuffer(static_cast<gzFile>(file_.get()), 1u << 17);
  constexpr std::size_t kMaxCompression = 1032;  // of zlib's format
  std::error_code code;
  if (reads_) most_ = kMaxCompression * std::filesystem::file_size(file, code);
}

Parts Parts::writer(const std::filesystem::path& file, bool compressed) {
  return {file, compressed ? "wb1" : "wb0"};
}

Parts Parts::reader(const std::filesystem::path& file) {
  return {file, "rb"};
}

bool Parts::bytes(void* data, std::size_t size) {
  constexpr std::size_t kPiece = 1u << 28;  // zlib states sizes as int
  const auto file = static_cast<gzFile>(file_.get());
  if (!file) return false;
  for (auto* at = static_cast<char*>(data); size > 0;) {
    const auto piece = static_cast<unsigned>(std::min(kPiece, size));
    const int done = reads_ ? gzread(file, at, piece) : gzwrite(file, at, piece);
    if (done <= 0) return false;
    at += done, size -= static_cast<std::size_t>(done);
  }
  return true;
}

bool Parts::close() {
  const auto file = static_cast<gzFile>(file_.get());
  return file && gzflush(file, Z_FINISH) == Z_OK;
}

void read_or_make(const Shelf& shelf, std::optional<std::uint64_t> key, const std::function<bool(Parts&)>& parts,
                  const std::function<void()>& make) {
  const std::filesystem::path in = folder(shelf.folder);
  if (key) {
    if (const auto file = find(in, *key, shelf.suffix); !file.empty()) {
      Parts read = Parts::reader(file);
      if (parts(read)) return;
    }
  }
  const Nanos began = now();
  make();
  if (!key || now() - began < shelf.worth) return;
  keep(in, *key, shelf.suffix, shelf.most, [&](const std::filesystem::path& file) {
    Parts written = Parts::writer(file, shelf.compressed);
    if (!parts(written) || !written.close()) throw Error(file.string(), "", "not written", "a writable place");
  });
}

}  // namespace typodont::cache
