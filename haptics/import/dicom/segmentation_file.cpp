#include "haptics/import/dicom/segmentation_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <random>
#include <vector>

#include "engine/base/error.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics::importing {

namespace {

// Data elements in explicit VR little endian. They must be added in the order of their tags.
class Elements {
 public:
  Elements& text(std::uint16_t group, std::uint16_t element, const char* vr, std::string value) {
    if (value.size() % 2) value += vr == std::string_view("UI") ? '\0' : ' ';
    return add(group, element, vr, value);
  }
  Elements& short_number(std::uint16_t group, std::uint16_t element, std::uint16_t value) {
    return add(group, element, "US", bytes_of(value, 2));
  }
  Elements& long_numbers(std::uint16_t group, std::uint16_t element, std::initializer_list<std::uint32_t> values) {
    std::string bytes;
    for (const std::uint32_t v : values) bytes += bytes_of(v, 4);
    return add(group, element, "UL", bytes);
  }
  Elements& pointer(std::uint16_t group, std::uint16_t element, std::uint32_t tag) {
    return add(group, element, "AT", bytes_of(tag >> 16, 2) + bytes_of(tag & 0xffff, 2));
  }
  Elements& sequence(std::uint16_t group, std::uint16_t element, const std::vector<Elements>& items) {
    std::string bytes;
    for (const Elements& item : items)
      bytes += bytes_of(0xfffe, 2) + bytes_of(0xe000, 2) + bytes_of(item.bytes_.size(), 4) + item.bytes_;
    return add(group, element, "SQ", bytes);
  }
  Elements& add(std::uint16_t group, std::uint16_t element, std::string_view vr, const std::string& value) {
    bytes_ += bytes_of(group, 2) + bytes_of(element, 2);
    bytes_ += vr;
    if (vr == "OB" || vr == "SQ")
      bytes_ += std::string(2, '\0') + bytes_of(value.size(), 4);
    else
      bytes_ += bytes_of(value.size(), 2);
    bytes_ += value;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  static std::string bytes_of(std::uint64_t value, int count) {
    std::string bytes;
    for (int k = 0; k < count; ++k) bytes += static_cast<char>(value >> (8 * k) & 0xff);
    return bytes;
  }
  std::string bytes_;
};

/// UID with 122 random bits (PS3.5, annex B.2).
std::string new_identifier() {
  std::random_device random;
  std::array<std::uint32_t, 4> number{};  // the most significant word first
  for (std::uint32_t& word : number) word = random();
  // Sets version 4 and the variant (RFC 4122).
  number[1] = (number[1] & 0xffff0fffu) | 0x4000u;
  number[2] = (number[2] & 0x3fffffffu) | 0x80000000u;
  std::string digits;
  while (std::ranges::any_of(number, [](std::uint32_t word) { return word > 0; })) {
    std::uint64_t rest = 0;
    for (std::uint32_t& word : number) {
      rest = rest << 32 | word;
      word = static_cast<std::uint32_t>(rest / 10);
      rest %= 10;
    }
    digits += static_cast<char>('0' + rest);
  }
  return "2.25." + std::string(digits.rbegin(), digits.rend());
}

/// Decimal text of at most 16 characters.
std::string decimal(double value) {
  if (std::abs(value) < 1e-9) value = 0;
  std::string text;
  for (int digits = 11; digits > 5; --digits) {
    text = fmt::format("{:.{}g}", value, digits);
    if (text.size() <= 16) break;
  }
  return text;
}
std::string decimals(const glm::dvec3& v) {
  return decimal(v.x) + '\\' + decimal(v.y) + '\\' + decimal(v.z);
}

Elements code(const char* value, const char* scheme, const char* meaning) {
  return Elements()
      .text(0x0008, 0x0100, "SH", value)
      .text(0x0008, 0x0102, "SH", scheme)
      .text(0x0008, 0x0104, "LO", meaning);
}

}  // namespace

std::string dicom_segmentation(const std::string& file, const glm::ivec3& size, const std::string& labels,
                               const glm::dmat3& step, const glm::dvec3& origin) {
  constexpr int kMaxEdge = 65535;
  if (size.x > kMaxEdge || size.y > kMaxEdge)
    throw Error(file, "size", fmt::format("{} x {} voxels in a slice", size.x, size.y),
                fmt::format("at most {} along an axis of a DICOM file; a .nrrd file has no such limit", kMaxEdge));

  // A frame of the file: one slice of one tissue. There is no frame for slices without this tissue.
  struct Frame {
    std::size_t segment;
    int z;
  };
  std::vector<Tissue> segments;
  std::vector<Frame> frames;
  const std::size_t slice = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  for (std::size_t t = 1; t < std::size_t{kTissueCount}; ++t) {
    const std::size_t before = frames.size();
    for (int z = 0; z < size.z; ++z) {
      const auto* from = &labels[static_cast<std::size_t>(z) * slice];
      if (std::find(from, from + slice, static_cast<char>(t)) != from + slice) frames.push_back({segments.size(), z});
    }
    if (frames.size() > before) segments.push_back(static_cast<Tissue>(t));
  }
  // Largest size of the labels in a DICOM file. The labels have one bit per voxel, without padding between frames.
  constexpr std::size_t kMaxBytes = 0xfffffffe;
  const std::size_t bytes = (frames.size() * slice + 7) / 8;
  if (frames.empty() || bytes > kMaxBytes)
    throw Error(file, "labels", frames.empty() ? "no labelled voxel" : fmt::format("{} bytes of labels", bytes),
                frames.empty() ? "tissue"
                               : fmt::format("at most {} bytes in a DICOM file; .nrrd has no such limit", kMaxBytes));
  std::string pixels(bytes + bytes % 2, '\0');
  std::size_t bit = 0;
  for (const Frame& f : frames) {
    const auto* from = &labels[static_cast<std::size_t>(f.z) * slice];
    const auto tissue = static_cast<char>(segments[f.segment]);
    for (std::size_t k = 0; k < slice; ++k, ++bit) {
      if (from[k] == tissue) pixels[bit / 8] = static_cast<char>(pixels[bit / 8] | 1 << bit % 8);
    }
  }

  const std::string instance = new_identifier(), dimensions = new_identifier();
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  const std::string date = fmt::format("{:04}{:02}{:02}", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday),
                    time = fmt::format("{:02}{:02}{:02}", utc.tm_hour, utc.tm_min, utc.tm_sec);
  constexpr const char* kClass = "1.2.840.10008.5.1.4.1.1.66.4";  // file class: Segmentation Storage

  std::vector<Elements> segment_items, frame_items;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    std::string name(name_of(segments[k]));
    std::ranges::replace(name, '_', ' ');
    Elements item;
    item.sequence(0x0062, 0x0003, {code("85756007", "SCT", "Tissue")})
        .short_number(0x0062, 0x0004, static_cast<std::uint16_t>(k + 1))
        .text(0x0062, 0x0005, "LO", name)
        .text(0x0062, 0x0008, "CS", "AUTOMATIC")
        .text(0x0062, 0x0009, "LO", "Typodont import")
        .sequence(0x0062, 0x000f, {code(std::string(name_of(segments[k])).c_str(), "99TYPODONT", name.c_str())});
    segment_items.push_back(std::move(item));
  }
  for (const Frame& f : frames) {
    const auto segment = static_cast<std::uint32_t>(f.segment + 1);
    Elements item;
    // Frame content (index in two dimensions), position, and segment number.
    item.sequence(0x0020, 0x9111,
                  {Elements().long_numbers(0x0020, 0x9157, {segment, static_cast<std::uint32_t>(f.z + 1)})})
        .sequence(0x0020, 0x9113,
                  {Elements().text(0x0020, 0x0032, "DS", decimals(origin + static_cast<double>(f.z) * step[2]))})
        .sequence(0x0062, 0x000a, {Elements().short_number(0x0062, 0x000b, static_cast<std::uint16_t>(f.segment + 1))});
    frame_items.push_back(std::move(item));
  }
  const glm::dvec3 spacing(glm::length(step[0]), glm::length(step[1]), glm::length(step[2]));
  const Elements shared =
      Elements()
          .sequence(0x0020, 0x9116,
                    {Elements().text(0x0020, 0x0037, "DS",
                                     decimals(step[0] / spacing.x) + '\\' + decimals(step[1] / spacing.y))})
          .sequence(0x0028, 0x9110,
                    {Elements()
                         .text(0x0018, 0x0050, "DS", decimal(spacing.z))
                         .text(0x0018, 0x0088, "DS", decimal(spacing.z))
                         .text(0x0028, 0x0030, "DS", decimal(spacing.y) + '\\' + decimal(spacing.x))});
  const auto dimension = [&](std::uint32_t index, std::uint32_t group, const char* label) {
    return Elements()
        .text(0x0020, 0x9164, "UI", dimensions)
        .pointer(0x0020, 0x9165, index)
        .pointer(0x0020, 0x9167, group)
        .text(0x0020, 0x9421, "LO", label);
  };

  Elements set;
  set.text(0x0008, 0x0008, "CS", "DERIVED\\PRIMARY")
      .text(0x0008, 0x0016, "UI", kClass)
      .text(0x0008, 0x0018, "UI", instance)
      .text(0x0008, 0x0020, "DA", "")
      .text(0x0008, 0x0023, "DA", date)
      .text(0x0008, 0x0030, "TM", "")
      .text(0x0008, 0x0033, "TM", time)
      .text(0x0008, 0x0050, "SH", "")
      .text(0x0008, 0x0060, "CS", "SEG")
      .text(0x0008, 0x0070, "LO", "Typodont")
      .text(0x0008, 0x0090, "PN", "")
      .text(0x0008, 0x1090, "LO", "Typodont")
      .text(0x0010, 0x0010, "PN", "")
      .text(0x0010, 0x0020, "LO", "")
      .text(0x0010, 0x0030, "DA", "")
      .text(0x0010, 0x0040, "CS", "")
      .text(0x0018, 0x1000, "LO", "none")
      .text(0x0018, 0x1020, "LO", TYPODONT_VERSION)
      .text(0x0020, 0x000d, "UI", new_identifier())
      .text(0x0020, 0x000e, "UI", new_identifier())
      .text(0x0020, 0x0010, "SH", "")
      .text(0x0020, 0x0011, "IS", "1")
      .text(0x0020, 0x0013, "IS", "1")
      .text(0x0020, 0x0052, "UI", new_identifier())
      .text(0x0020, 0x1040, "LO", "")
      .sequence(0x0020, 0x9221, {Elements().text(0x0020, 0x9164, "UI", dimensions)})
      .sequence(0x0020, 0x9222,
                {dimension(0x0062000b, 0x0062000a, "Segment"), dimension(0x00200032, 0x00209113, "Slice")})
      .short_number(0x0028, 0x0002, 1)
      .text(0x0028, 0x0004, "CS", "MONOCHROME2")
      .text(0x0028, 0x0008, "IS", fmt::format("{}", frames.size()))
      .short_number(0x0028, 0x0010, static_cast<std::uint16_t>(size.y))
      .short_number(0x0028, 0x0011, static_cast<std::uint16_t>(size.x))
      .short_number(0x0028, 0x0100, 1)
      .short_number(0x0028, 0x0101, 1)
      .short_number(0x0028, 0x0102, 0)
      .short_number(0x0028, 0x0103, 0)
      .text(0x0028, 0x2110, "CS", "00")
      .text(0x0062, 0x0001, "CS", "BINARY")
      .sequence(0x0062, 0x0002, segment_items)
      .text(0x0062, 0x0013, "CS", "NO")
      .text(0x0070, 0x0080, "CS", "TISSUES")
      .text(0x0070, 0x0081, "LO", "")
      .text(0x0070, 0x0084, "PN", "")
      .sequence(0x5200, 0x9229, {shared})
      .sequence(0x5200, 0x9230, frame_items)
      .add(0x7fe0, 0x0010, "OB", pixels);

  Elements meta;
  meta.add(0x0002, 0x0001, "OB", std::string("\0\1", 2))
      .text(0x0002, 0x0002, "UI", kClass)
      .text(0x0002, 0x0003, "UI", instance)
      .text(0x0002, 0x0010, "UI", "1.2.840.10008.1.2.1")
      .text(0x0002, 0x0012, "UI", "2.25.107340958317312867218303487172011826177")
      .text(0x0002, 0x0013, "SH", "TYPODONT");
  Elements length;
  length.long_numbers(0x0002, 0x0000, {static_cast<std::uint32_t>(meta.bytes().size())});
  return std::string(128, '\0') + "DICM" + length.bytes() + meta.bytes() + set.bytes();
}

}  // namespace typodont::haptics::importing
