// Writes DICOM files (PS3.10) of phantoms byte by byte, in four uncompressed transfer syntaxes. The files contain
// invented personal data that must not appear in any output.
#pragma once

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/deflated.h"
#include "tests/support/import_phantom.h"

namespace typodont::test {

inline constexpr const char* kPatient = "HUSH^HANNAH";
inline constexpr const char* kPatientId = "SSN-078-05-1120";
inline constexpr const char* kBirthDate = "19010203";

enum class Syntax { kExplicit, kImplicit, kBigEndian, kDeflated };

/// The values of one file that differ between files. All other values have defaults.
struct DicomImage {
  int columns = 0, rows = 0, frames = 1;
  std::vector<std::uint16_t> pixels;
  std::string series = "1.2.3.4", instance = "1.2.3.4.1";
  int series_number = 1, order = 1, acquisition = 1;
  std::optional<glm::dvec3> position;
  std::optional<std::pair<glm::dvec3, glm::dvec3>> orientation;  // direction along a row, direction down a column
  glm::dvec2 spacing{1};                                         // across, down
  double gap = 0, thickness = 0, slope = 1, intercept = 0, tilt = 0;
  std::string slope_text, kernel;  // slope_text: replaces `slope`
  std::optional<double> location;  // Slice Location
  std::optional<std::uint16_t> padding;
  std::uint16_t bits_stored = 16, high_bit = 15;
  std::string image_type = "ORIGINAL\\PRIMARY\\AXIAL";
  std::vector<glm::dvec3> frame_positions;  // for an enhanced image with many frames
};

class DicomWriter {
 public:
  explicit DicomWriter(Syntax syntax) : syntax_(syntax) {}

  void text(std::uint16_t group, std::uint16_t element, const char* vr, std::string value) {
    if (value.size() % 2) value += std::string(vr) == "UI" ? '\0' : ' ';
    add(group, element, vr, value);
  }
  void number(std::uint16_t group, std::uint16_t element, std::uint16_t value) {
    add(group, element, "US", shorts({value}));
  }
  void words(std::uint16_t group, std::uint16_t element, const std::vector<std::uint16_t>& values) {
    add(group, element, "OW", shorts(values));
  }
  void sequence(std::uint16_t group, std::uint16_t element, const std::vector<std::string>& items) {
    std::string all;
    for (const std::string& item : items) {
      all += tag(0xfffe, 0xe000) + long_number(static_cast<std::uint32_t>(item.size())) + item;
    }
    add(group, element, "SQ", all);
  }
  const std::string& bytes() const { return bytes_; }

  /// Returns the complete file with preamble and meta information.
  std::string file() const {
    DicomWriter meta(Syntax::kExplicit);
    static const std::map<Syntax, const char*> kUids = {{Syntax::kExplicit, "1.2.840.10008.1.2.1"},
                                                        {Syntax::kImplicit, "1.2.840.10008.1.2"},
                                                        {Syntax::kBigEndian, "1.2.840.10008.1.2.2"},
                                                        {Syntax::kDeflated, "1.2.840.10008.1.2.1.99"}};
    meta.text(0x0002, 0x0002, "UI", "1.2.840.10008.5.1.4.1.1.2");
    meta.text(0x0002, 0x0003, "UI", "1.2.3.4.5");
    meta.text(0x0002, 0x0010, "UI", kUids.at(syntax_));
    std::string length(4, '\0');
    const auto size = static_cast<std::uint32_t>(meta.bytes().size());
    std::memcpy(length.data(), &size, 4);
    DicomWriter group(Syntax::kExplicit);
    group.add(0x0002, 0x0000, "UL", length);
    std::string body = bytes_;
    if (syntax_ == Syntax::kDeflated) {
      body = deflated(bytes_, -15);
      if (body.size() % 2 != 0) body += '\0';
    }
    return std::string(128, '\0') + "DICM" + group.bytes() + meta.bytes() + body;
  }

 private:
  std::string ordered(const void* from, std::size_t n) const {
    std::string b(static_cast<const char*>(from), n);
    if (syntax_ == Syntax::kBigEndian) std::reverse(b.begin(), b.end());
    return b;
  }
  std::string short_number(std::uint16_t v) const { return ordered(&v, 2); }
  std::string long_number(std::uint32_t v) const { return ordered(&v, 4); }
  std::string tag(std::uint16_t group, std::uint16_t element) const {
    return short_number(group) + short_number(element);
  }
  std::string shorts(const std::vector<std::uint16_t>& values) const {
    std::string b;
    for (const std::uint16_t v : values) b += short_number(v);
    return b;
  }
  void add(std::uint16_t group, std::uint16_t element, const std::string& vr, const std::string& value) {
    const auto size = static_cast<std::uint32_t>(value.size());
    bytes_ += tag(group, element);
    if (syntax_ == Syntax::kImplicit)
      bytes_ += long_number(size);
    else if (vr == "OW" || vr == "SQ" || vr == "OB")
      bytes_ += vr + std::string(2, '\0') + long_number(size);
    else
      bytes_ += vr + short_number(static_cast<std::uint16_t>(size));
    bytes_ += value;
  }

  Syntax syntax_;
  std::string bytes_;
};

inline std::string decimals(const glm::dvec3& v) {
  return fmt::format("{:.10g}\\{:.10g}\\{:.10g}", v.x, v.y, v.z);
}

inline std::string dicom_bytes(const DicomImage& image, Syntax syntax = Syntax::kExplicit) {
  DicomWriter w(syntax);
  w.text(0x0008, 0x0008, "CS", image.image_type);
  w.text(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.2");
  w.text(0x0008, 0x0018, "UI", image.instance);
  w.text(0x0008, 0x0060, "CS", "CT");
  w.text(0x0008, 0x103e, "LO", kPatient);  // some clinics write names into this field
  w.text(0x0010, 0x0010, "PN", kPatient);
  w.text(0x0010, 0x0020, "LO", kPatientId);
  w.text(0x0010, 0x0030, "DA", kBirthDate);
  if (image.thickness > 0) w.text(0x0018, 0x0050, "DS", fmt::format("{:.10g}", image.thickness));
  if (image.gap > 0) w.text(0x0018, 0x0088, "DS", fmt::format("{:.10g}", image.gap));
  if (image.tilt != 0) w.text(0x0018, 0x1120, "DS", fmt::format("{:.10g}", image.tilt));
  if (!image.kernel.empty()) w.text(0x0018, 0x1210, "SH", image.kernel);
  w.text(0x0020, 0x000d, "UI", "1.2.3");
  w.text(0x0020, 0x000e, "UI", image.series);
  w.text(0x0020, 0x0011, "IS", fmt::format("{}", image.series_number));
  w.text(0x0020, 0x0012, "IS", fmt::format("{}", image.acquisition));
  w.text(0x0020, 0x0013, "IS", fmt::format("{}", image.order));
  if (image.position) w.text(0x0020, 0x0032, "DS", decimals(*image.position));
  if (image.orientation)
    w.text(0x0020, 0x0037, "DS", decimals(image.orientation->first) + "\\" + decimals(image.orientation->second));
  if (image.location) w.text(0x0020, 0x1041, "DS", fmt::format("{:.10g}", *image.location));
  w.number(0x0028, 0x0002, 1);
  w.text(0x0028, 0x0004, "CS", "MONOCHROME2");
  if (image.frames > 1) w.text(0x0028, 0x0008, "IS", fmt::format("{}", image.frames));
  w.number(0x0028, 0x0010, static_cast<std::uint16_t>(image.rows));
  w.number(0x0028, 0x0011, static_cast<std::uint16_t>(image.columns));
  if (image.spacing.x > 0)
    w.text(0x0028, 0x0030, "DS", fmt::format("{:.10g}\\{:.10g}", image.spacing.y, image.spacing.x));
  w.number(0x0028, 0x0100, 16);
  w.number(0x0028, 0x0101, image.bits_stored);
  w.number(0x0028, 0x0102, image.high_bit);
  w.number(0x0028, 0x0103, 0);
  if (image.padding) w.number(0x0028, 0x0120, *image.padding);
  w.text(0x0028, 0x1052, "DS", fmt::format("{:.10g}", image.intercept));
  w.text(0x0028, 0x1053, "DS", image.slope_text.empty() ? fmt::format("{:.10g}", image.slope) : image.slope_text);
  if (!image.frame_positions.empty()) {
    std::vector<std::string> frames;
    for (const glm::dvec3& p : image.frame_positions) {
      DicomWriter place(syntax), item(syntax);
      place.text(0x0020, 0x0032, "DS", decimals(p));
      item.sequence(0x0020, 0x9113, {place.bytes()});
      frames.push_back(item.bytes());
    }
    w.sequence(0x5200, 0x9230, frames);
  }
  w.words(0x7fe0, 0x0010, image.pixels);
  return w.file();
}

/// Position of a scan's array in the patient: the directions of x, y and z (unit vectors) and the position of voxel
/// (0,0,0).
struct Placed {
  glm::dvec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin{0};
};

/// Returns the slices of a scan as files of a folder. x is the fastest index.
inline std::vector<DicomImage> slices_of(const std::vector<double>& greys, const glm::ivec3& size,
                                         const glm::dvec3& spacing, const Placed& placed = {}) {
  std::vector<DicomImage> images;
  const std::size_t area = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  for (int k = 0; k < size.z; ++k) {
    DicomImage i;
    i.columns = size.x, i.rows = size.y;
    for (std::size_t p = 0; p < area; ++p)
      i.pixels.push_back(static_cast<std::uint16_t>(std::lround(greys[static_cast<std::size_t>(k) * area + p])));
    i.instance = fmt::format("1.2.3.4.{}", k + 1);
    i.order = k + 1;
    i.position = placed.origin + spacing.z * k * placed.z;
    i.orientation = {placed.x, placed.y};
    i.spacing = {spacing.x, spacing.y};
    images.push_back(std::move(i));
  }
  return images;
}

/// Writes the files with names that do not show their order.
inline std::filesystem::path write_series(const std::string& folder, const std::vector<DicomImage>& images,
                                          Syntax syntax = Syntax::kExplicit) {
  std::filesystem::create_directories(scratch(folder));
  for (std::size_t k = 0; k < images.size(); ++k)
    write(scratch(folder) / fmt::format("{}_{:03}.dcm", kPatient, k * 37 % 101), dicom_bytes(images[k], syntax));
  return scratch(folder);
}

/// Returns a zip archive of the files, deflated or stored.
inline std::string zip_bytes(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string out, list;
  const auto put = [](std::string& to, auto value) { to.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (std::size_t k = 0; k < files.size(); ++k) {
    const auto& [name, bytes] = files[k];
    const bool deflate_it = k % 2 == 0;
    const std::string packed = deflate_it ? deflated(bytes, -15) : bytes;
    const auto crc = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
    const auto at = static_cast<std::uint32_t>(out.size());
    const auto head = [&](std::string& to, bool local) {
      put(to, static_cast<std::uint32_t>(local ? 0x04034b50 : 0x02014b50));
      if (!local) put(to, std::uint16_t{20});
      for (const int v : {20, 0, deflate_it ? 8 : 0, 0, 0}) put(to, static_cast<std::uint16_t>(v));
      put(to, crc);
      put(to, static_cast<std::uint32_t>(packed.size()));
      put(to, static_cast<std::uint32_t>(bytes.size()));
      put(to, static_cast<std::uint16_t>(name.size()));
      put(to, std::uint16_t{0});
      if (!local) {
        for (int i = 0; i < 3; ++i) put(to, std::uint16_t{0});
        put(to, std::uint32_t{0});
        put(to, at);
      }
      to += name;
    };
    head(out, true);
    out += packed;
    head(list, false);
  }
  const auto start = static_cast<std::uint32_t>(out.size()), length = static_cast<std::uint32_t>(list.size());
  out += list;
  put(out, std::uint32_t{0x06054b50});
  for (int i = 0; i < 2; ++i) put(out, std::uint16_t{0});
  for (int i = 0; i < 2; ++i) put(out, static_cast<std::uint16_t>(files.size()));
  put(out, length);
  put(out, start);
  put(out, std::uint16_t{0});
  return out;
}

}  // namespace typodont::test
