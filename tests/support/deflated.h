// Compresses bytes with zlib, as in scans and archives.
#pragma once

#include <zlib.h>

#include <string>

namespace typodont::test {

/// Returns the compressed bytes. `window`: 15 with a zlib header, 31 with a gzip header, -15 without a header.
inline std::string deflated(const std::string& bytes, int window) {
  z_stream z{};
  deflateInit2(&z, 9, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&z, bytes.size()) + 64, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  z.avail_in = static_cast<uInt>(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

}  // namespace typodont::test
