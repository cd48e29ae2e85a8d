// MetaImage (.mha, .mhd): lines "Key = Value", then plain or zlib data. Other libraries do not check the header, so
// Typodont has its own reader.
#include <fmt/format.h>
#include <zlib.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <map>

#include "engine/base/error.h"
#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

namespace {
struct Entry {
  std::string value;
  int line = 0;
};
struct Header {
  std::filesystem::path file;
  std::map<std::string, Entry, std::less<>> entries;
  std::streamoff end = 0;  // position of the header's end in the file, bytes; LOCAL data begin there

  const Entry* find(std::string_view key) const {
    const auto it = entries.find(key);
    return it == entries.end() ? nullptr : &it->second;
  }
  [[noreturn]] void fail(std::string_view key, std::string_view expected) const {
    const Entry* e = find(key);
    if (!e) throw Error(file.string(), "header", fmt::format("no {}", key), expected);
    throw Error(file.string(), fmt::format("line {} ({})", e->line, key), excerpt(e->value), expected);
  }
  bool flag(std::string_view key, bool fallback) const {
    const Entry* e = find(key);
    if (!e) return fallback;
    if (e->value == "True" || e->value == "true" || e->value == "1") return true;
    if (e->value == "False" || e->value == "false" || e->value == "0") return false;
    fail(key, "True or False");
  }
  std::vector<double> numbers(std::string_view key, std::size_t count) const {
    const Entry* e = find(key);
    const auto n = e ? parse_numbers(e->value) : std::nullopt;
    if (!n || n->size() != count) fail(key, fmt::format("{} number{}", count, count == 1 ? "" : "s"));
    return *n;
  }
};
}  // namespace

static std::string trimmed(const std::string& s) {
  const auto a = s.find_first_not_of(" \t\r");
  return a == std::string::npos ? "" : s.substr(a, s.find_last_not_of(" \t\r") - a + 1);
}

static Header read_header(const std::filesystem::path& file) {
  Header header;
  header.file = file;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(file.string(), "", "an unreadable file", "a MetaImage");
  std::string line;
  constexpr std::size_t kLongestLine = 1 << 16;
  for (int number = 1; number <= 500; ++number) {
    read_line(in, line, kLongestLine);
    if (trimmed(line).empty()) {
      if (!in) break;
      continue;
    }
    const auto equals = line.find('=');
    if (equals == std::string::npos)
      throw Error(file.string(), fmt::format("line {}", number), excerpt(line), "Key = Value");
    const std::string key = trimmed(line.substr(0, equals));
    header.entries[key] = {trimmed(line.substr(equals + 1)), number};
    if (key == "ElementDataFile") {  // this key must be the last one of the header
      header.end = in ? static_cast<std::streamoff>(in.tellg()) : static_cast<std::streamoff>(size_of_file(file));
      return header;
    }
  }
  throw Error(file.string(), "header", "no ElementDataFile",
              "a line \"ElementDataFile = LOCAL\" or the name of a file");
}

static std::vector<char> read_bytes(const std::filesystem::path& file, std::uintmax_t from, std::uintmax_t count) {
  std::vector<char> bytes(count);
  std::ifstream in(file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(from));
  in.read(bytes.data(), static_cast<std::streamsize>(count));
  if (static_cast<std::uintmax_t>(in.gcount()) != count) {
    throw Error(file.string(), "data", fmt::format("{} bytes", in.gcount()), fmt::format("{} bytes", count));
  }
  return bytes;
}

static std::vector<char> unpack(const std::filesystem::path& file, const std::vector<char>& packed, std::size_t bytes) {
  std::vector<char> out(bytes);
  z_stream z{};
  // 15 + 32: accepts zlib and gzip.
  if (inflateInit2(&z, 15 + 32) != Z_OK) throw RunFailure("zlib does not start");
  std::size_t in = 0, got = 0;
  int state = Z_OK;
  while (state == Z_OK && got < bytes) {  // the loop is needed because zlib counts with 32 bits
    const std::size_t give = std::min<std::size_t>(packed.size() - in, 1 << 30),
                      room = std::min<std::size_t>(bytes - got, 1 << 30);
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data() + in));
    z.avail_in = static_cast<uInt>(give);
    z.next_out = reinterpret_cast<Bytef*>(out.data() + got);
    z.avail_out = static_cast<uInt>(room);
    state = inflate(&z, Z_NO_FLUSH);
    in += give - z.avail_in;
    got += room - z.avail_out;
    if (give == z.avail_in && room == z.avail_out) break;
  }
  const std::string why = z.msg ? fmt::format(" ({})", z.msg) : "";
  inflateEnd(&z);
  if (got != bytes) {
    throw Error(file.string(), "compressed data", fmt::format("{} bytes after unpacking{}", got, why),
                fmt::format("{} bytes", bytes));
  }
  return out;
}

static RawScan read_metaimage(const ScanRequest& request) {
  const std::filesystem::path& file = request.file;
  const Header header = read_header(file);
  const double axes = header.numbers("NDims", 1)[0];
  if (axes != std::floor(axes) || axes < 3 || axes > 10)
    header.fail("NDims", "3, or more if the further axes have size 1");
  const auto n_axes = static_cast<std::size_t>(axes);
  const auto vector3 = [&](std::string_view key) {
    std::vector<double> all = header.numbers(key, n_axes);
    all.resize(3);
    return all;
  };
  for (std::size_t a = 3; a < n_axes; ++a) {
    if (header.numbers("DimSize", n_axes)[a] != 1) header.fail("DimSize", "3 axes longer than one");
  }
  const std::vector<double> dims = vector3("DimSize");
  std::vector<long long> sizes;
  for (const double d : dims) {
    if (!(d >= 1 && d <= 1e9) || d != std::floor(d)) header.fail("DimSize", "3 whole numbers");
    sizes.push_back(static_cast<long long>(d));
  }
  check_sizes(file, fmt::format("line {} (DimSize)", header.find("DimSize")->line), sizes, request.memory);
  if (header.find("ElementNumberOfChannels") && header.numbers("ElementNumberOfChannels", 1)[0] != 1) {
    header.fail("ElementNumberOfChannels", "1");
  }
  static const std::map<std::string_view, Element> kTypes = {
      {"MET_CHAR", Element::kInt8},
      {"MET_UCHAR", Element::kUint8},
      {"MET_SHORT", Element::kInt16},
      {"MET_USHORT", Element::kUint16},
      {"MET_INT", Element::kInt32},
      {"MET_UINT", Element::kUint32},
      // In MetaImage, MET_LONG and MET_ULONG always have 4 bytes.
      {"MET_LONG", Element::kInt32},
      {"MET_ULONG", Element::kUint32},
      {"MET_LONG_LONG", Element::kInt64},
      {"MET_ULONG_LONG", Element::kUint64},
      {"MET_FLOAT", Element::kFloat},
      {"MET_DOUBLE", Element::kDouble},
  };
  const Entry* type_entry = header.find("ElementType");
  const auto type = kTypes.find(type_entry ? std::string_view(type_entry->value) : std::string_view());
  if (type == kTypes.end()) header.fail("ElementType", "a scalar type such as MET_USHORT or MET_FLOAT");
  const Element element = type->second;
  const auto count =
      static_cast<std::size_t>(sizes[0]) * static_cast<std::size_t>(sizes[1]) * static_cast<std::size_t>(sizes[2]);
  const std::size_t bytes = count * bytes_of(element);

  // Finds the file with the voxel values, and their position in this file.
  std::string name = header.find("ElementDataFile")->value;
  const bool local = name == "LOCAL" || name == "Local" || name == "local";
  if (name.empty() || name.starts_with("LIST") || name.find('%') != std::string::npos) {
    header.fail("ElementDataFile", "LOCAL or the name of one file");
  }
  // A path that does not exist may be from another computer: then the file must be in the header's folder.
  const auto foreign = name.find_last_of("\\/");
  if (!local && foreign != std::string::npos && !std::filesystem::exists(file.parent_path() / name))
    name.erase(0, foreign + 1);
  const std::filesystem::path data = local ? file : file.parent_path() / name;
  const std::uintmax_t total = size_of_file(data);
  std::uintmax_t from = local ? static_cast<std::uintmax_t>(header.end) : 0;
  const bool packed = header.flag("CompressedData", false);
  const bool binary = header.flag("BinaryData", true);
  if (header.find("HeaderSize")) {
    const double skip = header.numbers("HeaderSize", 1)[0];
    if (skip == -1 && !packed) {
      from = total >= bytes ? total - bytes : 0;
    } else if (skip >= 0 && skip < 1e9) {
      from += static_cast<std::uintmax_t>(skip);
    } else {
      header.fail("HeaderSize", "a number of bytes to skip");
    }
  }
  const std::uintmax_t present = total > from ? total - from : 0;
  RawScan scan;
  scan.format = "MetaImage";
  scan.space = "LPS";
  scan.has_unit = true;  // mm, unless the file states another unit
  double unit = 1;       // mm, length of the unit
  if (const Entry* e = header.find("DistanceUnits"); e && e->value == "?") {
    scan.has_unit = false;
  } else if (e) {
    const std::optional<double> factor = millimetres_per(e->value);
    if (!factor) header.fail("DistanceUnits", "a unit of length (mm, um, cm or m)");
    unit = *factor;
  }
  scan.size = {static_cast<int>(sizes[0]), static_cast<int>(sizes[1]), static_cast<int>(sizes[2])};
  if (!binary) {
    if (static_cast<double>(present) < 2.0 * static_cast<double>(count) - 1) {
      throw Error(data.string(), "data", fmt::format("{} bytes", present), fmt::format("{} numbers as text", count));
    }
    const std::vector<char> text = read_bytes(data, from, present);
    const auto numbers = parse_numbers({text.data(), text.size()});
    if (!numbers || numbers->size() < count) {
      throw Error(data.string(), "data",
                  numbers ? fmt::format("{} numbers", numbers->size()) : "other things than numbers",
                  fmt::format("{} numbers as text", count));
    }
    scan.grey.assign(numbers->begin(), numbers->begin() + static_cast<std::ptrdiff_t>(count));
  } else {
    bool swap = header.flag("BinaryDataByteOrderMSB", header.flag("ElementByteOrderMSB", false));
    if (std::endian::native == std::endian::big) swap = !swap;
    const double least = packed ? static_cast<double>(bytes) / 1032 : static_cast<double>(bytes);
    if (static_cast<double>(present) < least) {
      throw Error(data.string(), "data", fmt::format("{} bytes", present),
                  fmt::format("at least {:.0f} bytes", std::ceil(least)));
    }
    const std::vector<char> read = read_bytes(data, from, packed ? present : bytes);
    scan.grey = decode(packed ? unpack(data, read, bytes) : read, count, element, swap);
  }

  // Reads spacing, directions and origin.
  const char* spacing = header.find("ElementSpacing") ? "ElementSpacing" : "ElementSize";
  scan.spacing_place =
      header.find(spacing) ? fmt::format("line {} ({})", header.find(spacing)->line, spacing) : "header";
  std::vector<double> mm{1, 1, 1};
  if (header.find(spacing)) {
    mm = vector3(spacing);
    for (double& edge : mm) edge *= unit;
    scan.has_spacing = mm[0] > 0 && mm[1] > 0 && mm[2] > 0;
  }
  std::vector<double> directions{1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (const char* key : {"TransformMatrix", "Rotation", "Orientation"}) {
    if (!header.find(key)) continue;
    const std::vector<double> all = header.numbers(key, n_axes * n_axes);
    for (std::size_t a = 0; a < 9; ++a) directions[a] = all[a / 3 * n_axes + a % 3];
  }
  for (const char* key : {"Offset", "Position", "Origin"}) {
    if (!header.find(key)) continue;
    const std::vector<double> o = vector3(key);
    scan.origin = unit * glm::dvec3(o[0], o[1], o[2]);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    glm::dvec3 along(directions[3 * k], directions[3 * k + 1], directions[3 * k + 2]);
    if (!(glm::length(along) > 1e-9))
      header.fail(header.find("TransformMatrix") ? "TransformMatrix" : "Orientation", "three directions");
    scan.step[k] = glm::normalize(along) * (scan.has_spacing ? mm[k] : 1.0);
  }
  return scan;
}

extern const ScanFormat metaimage_format;
const ScanFormat metaimage_format{
    "MetaImage",
    {".mha", ".mhd"},
    {},
    [](std::string_view bytes) { return bytes.find("NDims =") != std::string_view::npos; },
    read_metaimage};

}  // namespace typodont::haptics::importing
