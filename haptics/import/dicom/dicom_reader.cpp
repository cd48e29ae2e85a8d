// Program typodont-dicom-reader headers|pixels LIST IMAGE OUTPUT: reads DICOM with GDCM in a restricted process,
// because GDCM crashes on some damaged files.
// LIST: file names, each with a zero byte at its end. IMAGE, OUTPUT: largest sizes in bytes (dicom_wire.h).
#include <gdcmAttribute.h>
#include <gdcmImageReader.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "engine/base/fnv.h"
#include "engine/base/guarded_process.h"
#include "haptics/import/dicom/dicom_wire.h"
#include "haptics/import/scan_element.h"

namespace {

using namespace typodont;
using namespace typodont::haptics::importing;

const gdcm::Tag kPixelData(0x7fe0, 0x0010);
constexpr std::size_t kMaxFrames = 4096;

void write_all(const void* from, std::size_t bytes) {
  const char* p = static_cast<const char*>(from);
  while (bytes > 0) {
    const ssize_t n = ::write(1, p, bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) std::_Exit(3);  // the parent process no longer reads the output
    p += n, bytes -= static_cast<std::size_t>(n);
  }
}
template <class T>
void say(DicomRecord record, const T& value) {
  write_all(&record, sizeof record);
  write_all(&value, sizeof value);
}
void say_text(DicomRecord record, std::string text) {
  text.resize(std::min<std::size_t>(text.size(), 500));
  say(record, static_cast<std::uint32_t>(text.size()));
  write_all(text.data(), text.size());
}

/// Text of an attribute without padding.
std::string text_of(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  if (!set.FindDataElement(tag)) return "";
  const gdcm::ByteValue* value = set.GetDataElement(tag).GetByteValue();
  if (!value || value->GetLength() > 4096) return "";
  std::string text(value->GetPointer(), value->GetLength());
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}
/// Thrown for an unreadable number, such as "1,5".
struct Malformed {
  std::string place, found;
};
/// Reads `count` numbers from a text such as "1\2\3". Returns false if they are missing or empty; throws Malformed if
/// the text is not numbers.
bool numbers_of(const gdcm::DataSet& set, const gdcm::Tag& tag, const char* name, double* to, std::size_t count) {
  const std::string text = text_of(set, tag);
  if (text.find_first_not_of(' ') == std::string::npos) return false;
  std::vector<double> numbers;
  bool whole = true;
  for (std::size_t from = 0; whole && from <= text.size();) {
    const std::size_t end = std::min(text.find('\\', from), text.size());
    const std::string part = text.substr(from, end - from);
    char* rest = nullptr;
    const double number = std::strtod(part.c_str(), &rest);
    whole =
        rest != part.c_str() && std::string(rest).find_first_not_of(' ') == std::string::npos && std::isfinite(number);
    numbers.push_back(number);
    from = end + 1;
  }
  if (!whole || numbers.size() < count) {
    char place[80];
    std::snprintf(place, sizeof place, "%s (%04x,%04x)", name, tag.GetGroup(), tag.GetElement());
    throw Malformed{place, text};
  }
  std::copy_n(numbers.begin(), count, to);
  return true;
}
/// Reads a number that is not needed to place or scale a slice. Returns `otherwise` if it is missing or malformed.
double number_of(const gdcm::DataSet& set, const gdcm::Tag& tag, double otherwise) {
  double value = otherwise;
  try {
    return numbers_of(set, tag, "", &value, 1) ? value : otherwise;
  } catch (const Malformed&) {
    return otherwise;
  }
}
std::uint32_t short_of(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  if (!set.FindDataElement(tag)) return 0;
  const gdcm::ByteValue* value = set.GetDataElement(tag).GetByteValue();
  std::uint16_t number = 0;
  if (value && value->GetLength() >= sizeof number) std::memcpy(&number, value->GetPointer(), sizeof number);
  return number;
}
std::uint64_t hash_of(const std::string& text) {
  Fnv1a hash;
  hash.bytes(text.data(), text.size());
  return hash.value;
}

/// `set`: the whole file, or an item of the frame's functional groups.
void read_frame(const gdcm::DataSet& set, DicomFrame& f) {
  if (numbers_of(set, gdcm::Tag(0x0020, 0x0032), "Image Position", f.position, 3)) f.has_position = 1;
  if (numbers_of(set, gdcm::Tag(0x0020, 0x0037), "Image Orientation", f.orientation, 6)) f.has_orientation = 1;
  if (numbers_of(set, gdcm::Tag(0x0028, 0x0030), "Pixel Spacing", f.spacing, 2)) f.has_spacing = 1;
  if (numbers_of(set, gdcm::Tag(0x0020, 0x1041), "Slice Location", &f.location, 1)) f.has_location = 1;
  double gap = 0;
  numbers_of(set, gdcm::Tag(0x0018, 0x0088), "Spacing Between Slices", &gap, 1);
  if (gap > 0) f.has_gap = 1, f.gap = gap, f.gap_is_thickness = 0;
  double thickness = 0;
  numbers_of(set, gdcm::Tag(0x0018, 0x0050), "Slice Thickness", &thickness, 1);
  if (thickness > 0 && !f.has_gap) f.has_gap = 1, f.gap = thickness, f.gap_is_thickness = 1;
  numbers_of(set, gdcm::Tag(0x0028, 0x1053), "Rescale Slope", &f.slope, 1);
  numbers_of(set, gdcm::Tag(0x0028, 0x1052), "Rescale Intercept", &f.intercept, 1);
}
void read_groups(const gdcm::DataSet& set, DicomFrame& f) {
  // Reads plane position, plane orientation, pixel measures, and value transformation.
  for (const gdcm::Tag& tag :
       {gdcm::Tag(0x0020, 0x9113), gdcm::Tag(0x0020, 0x9116), gdcm::Tag(0x0028, 0x9110), gdcm::Tag(0x0028, 0x9145)}) {
    if (!set.FindDataElement(tag)) continue;
    const auto items = set.GetDataElement(tag).GetValueAsSQ();
    if (items && items->GetNumberOfItems() > 0) read_frame(items->GetItem(1).GetNestedDataSet(), f);
  }
}

void read_references(const gdcm::DataSet& set) {
  const gdcm::Tag records(0x0004, 0x1220), file(0x0004, 0x1500);
  if (!set.FindDataElement(records)) return;
  const auto items = set.GetDataElement(records).GetValueAsSQ();
  for (std::size_t k = 1; items && k <= items->GetNumberOfItems(); ++k) {
    std::string name = text_of(items->GetItem(k).GetNestedDataSet(), file);
    std::replace(name.begin(), name.end(), '\\', '/');
    if (!name.empty()) say_text(DicomRecord::kReference, name);
  }
}

void headers(const std::string& name, std::uint32_t number) {
  gdcm::Reader reader;
  reader.SetFileName(name.c_str());
  DicomFile file;
  file.number = number;
  if (!reader.ReadUpToTag(kPixelData)) {
    file.kind = DicomKind::kUnreadable;
    say(DicomRecord::kFile, file);
    return;
  }
  // Values are already in this computer's byte order.
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  file.columns = short_of(set, gdcm::Tag(0x0028, 0x0011));
  file.rows = short_of(set, gdcm::Tag(0x0028, 0x0010));
  file.frames = static_cast<std::uint32_t>(std::clamp(number_of(set, gdcm::Tag(0x0028, 0x0008), 1), 0.0, 1e9));
  file.series = hash_of(text_of(set, gdcm::Tag(0x0020, 0x000e)));
  file.instance = hash_of(text_of(set, gdcm::Tag(0x0008, 0x0018)));
  const auto whole = [&](const gdcm::Tag& tag) {
    return static_cast<std::int32_t>(std::clamp(number_of(set, tag, 0), -1e9, 1e9));
  };
  file.series_number = whole(gdcm::Tag(0x0020, 0x0011));
  file.acquisition = whole(gdcm::Tag(0x0020, 0x0012));
  file.phase = whole(gdcm::Tag(0x0020, 0x0100));
  file.echo = whole(gdcm::Tag(0x0018, 0x0086));
  file.order = whole(gdcm::Tag(0x0020, 0x0013));
  file.tilt = number_of(set, gdcm::Tag(0x0018, 0x1120), 0);
  file.derived_view = text_of(set, gdcm::Tag(0x0008, 0x0008)).find("LOCALIZER") != std::string::npos;
  const std::string modality = text_of(set, gdcm::Tag(0x0008, 0x0060));
  for (std::size_t k = 0; k < std::min<std::size_t>(modality.size(), 4); ++k)
    file.modality[k] = modality[k] >= 'A' && modality[k] <= 'Z' ? modality[k] : '?';
  const std::string kernel = text_of(set, gdcm::Tag(0x0018, 0x1210));
  for (std::size_t k = 0; k < std::min(kernel.size(), sizeof file.kernel - 1); ++k)
    file.kernel[k] = kernel[k] >= ' ' && kernel[k] <= '~' ? kernel[k] : '?';
  // A segmentation has one bit per voxel, not grey values.
  const bool segmentation = short_of(set, gdcm::Tag(0x0028, 0x0100)) == 1;
  const bool image = file.columns > 0 && file.rows > 0 && file.frames > 0 && !segmentation;
  const bool color = short_of(set, gdcm::Tag(0x0028, 0x0002)) > 1;
  file.kind = set.FindDataElement(gdcm::Tag(0x0004, 0x1220)) ? DicomKind::kDirectory
              : !image                                       ? DicomKind::kNoImage
              : color                                        ? DicomKind::kColor
                                                             : DicomKind::kImage;
  say(DicomRecord::kFile, file);
  if (file.kind == DicomKind::kDirectory) read_references(set);
  if (file.kind != DicomKind::kImage || file.frames > kMaxFrames) return;
  DicomFrame common;
  read_frame(set, common);
  const auto groups_of = [&](const gdcm::Tag& tag) {
    return set.FindDataElement(tag) ? set.GetDataElement(tag).GetValueAsSQ() : nullptr;
  };
  const auto shared = groups_of(gdcm::Tag(0x5200, 0x9229)), per_frame = groups_of(gdcm::Tag(0x5200, 0x9230));
  if (shared && shared->GetNumberOfItems() > 0) read_groups(shared->GetItem(1).GetNestedDataSet(), common);
  for (std::uint32_t k = 0; k < file.frames; ++k) {
    DicomFrame frame = common;
    if (per_frame && k < per_frame->GetNumberOfItems())
      read_groups(per_frame->GetItem(k + 1).GetNestedDataSet(), frame);
    else if (k > 0)
      // If the file has one position for all frames, only the first frame has it.
      frame.has_position = 0;
    say(DicomRecord::kFrame, frame);
  }
}

/// Returns true if the file ends before its pixels do; GDCM would silently fill in the missing pixels.
bool is_cut(const std::string& name, const gdcm::File& file, const gdcm::Image& image) {
  const gdcm::TransferSyntax& syntax = file.GetHeader().GetDataSetTransferSyntax();
  std::ifstream in(name, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (syntax.IsEncapsulated()) {  // the mark at the end of compressed fragments
    return bytes.rfind(std::string("\xfe\xff\xdd\xe0", 4)) == std::string::npos;
  }
  if (syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian) {
    constexpr std::size_t kPreamble = 132 + 12, kPiece = 1 << 16;
    std::uint32_t meta = 0;  // length of the file's meta information, bytes
    if (bytes.size() < kPreamble) return true;
    std::memcpy(&meta, &bytes[kPreamble - 4], sizeof meta);
    if (meta > bytes.size() - kPreamble) return true;
    z_stream z{};
    if (inflateInit2(&z, -15) != Z_OK) return true;
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + kPreamble + meta));
    z.avail_in = static_cast<uInt>(std::min<std::size_t>(bytes.size() - kPreamble - meta, UINT_MAX));
    std::vector<Bytef> piece(kPiece);
    int state = Z_OK;
    while (state == Z_OK) {
      z.next_out = piece.data(), z.avail_out = kPiece;
      state = inflate(&z, Z_NO_FLUSH);
    }
    inflateEnd(&z);
    return state != Z_STREAM_END;
  }
  // Compares the stated length with the bytes that follow. Encoding of tag and length depend on the transfer syntax.
  const gdcm::ByteValue* value = image.GetDataElement().GetByteValue();
  if (!value) return true;
  const std::uint32_t length = value->GetLength();
  const bool big = syntax == gdcm::TransferSyntax::ExplicitVRBigEndian;
  const std::string tag = big ? std::string("\x7f\xe0\0\x10", 4) : std::string("\xe0\x7f\x10\0", 4);
  std::string size(reinterpret_cast<const char*>(&length), sizeof length);
  if (big) std::reverse(size.begin(), size.end());
  // Explicit VR: the type and two zero bytes come before the length.
  const std::size_t before = syntax.IsImplicit() ? 4 : 8;
  for (std::size_t at = bytes.rfind(tag); at != std::string::npos; at = at == 0 ? at - 1 : bytes.rfind(tag, at - 1)) {
    if (bytes.compare(std::min(at + before, bytes.size()), 4, size) != 0) continue;
    return bytes.size() - (at + before + 4) < length;
  }
  return true;
}

/// If High Bit > Bits Stored - 1, shifts the values down. Returns false if the attributes contradict each other.
bool remove_low_bits(const gdcm::File& file, const gdcm::Image& image, std::vector<char>& bytes) {
  const gdcm::DataSet& set = file.GetDataSet();
  const std::uint32_t allocated = short_of(set, gdcm::Tag(0x0028, 0x0100)),
                      stored = short_of(set, gdcm::Tag(0x0028, 0x0101)),
                      high = short_of(set, gdcm::Tag(0x0028, 0x0102));
  if (allocated != 16 || high + 1 == stored) return true;
  const gdcm::TransferSyntax& syntax = file.GetHeader().GetDataSetTransferSyntax();
  const gdcm::ByteValue* raw = image.GetDataElement().GetByteValue();
  // Reads the bytes of the file itself, because GDCM returns wrong numbers if the stored values do not begin at bit 0.
  if (stored == 0 || high + 1 < stored || high > 15 || syntax.IsEncapsulated() || !raw ||
      syntax == gdcm::TransferSyntax::ExplicitVRBigEndian || raw->GetLength() < bytes.size())
    return false;
  const bool is_signed = short_of(set, gdcm::Tag(0x0028, 0x0103)) == 1;
  for (std::size_t k = 0; k + 1 < bytes.size(); k += 2) {
    std::uint16_t bits = 0;
    std::memcpy(&bits, raw->GetPointer() + k, sizeof bits);
    bits = static_cast<std::uint16_t>(bits << (15 - high));  // removes bits above the highest bit of the value
    const unsigned shift = 16 - stored;
    const std::uint16_t value = is_signed ? static_cast<std::uint16_t>(static_cast<std::int16_t>(bits) >> shift)
                                          : static_cast<std::uint16_t>(bits >> shift);
    std::memcpy(&bytes[k], &value, sizeof value);
  }
  return true;
}

void pixels(const std::string& name, std::uint32_t number) {
  gdcm::ImageReader reader;
  reader.SetFileName(name.c_str());
  if (!reader.Read()) return say_text(DicomRecord::kRefused, "no pixels that can be decoded");
  const gdcm::Image& image = reader.GetImage();
  if (is_cut(name, reader.GetFile(), image)) return say_text(DicomRecord::kRefused, "pixels that are cut off");
  DicomPixels head;
  head.number = number;
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  const gdcm::PixelFormat& format = image.GetPixelFormat();
  if (format.GetSamplesPerPixel() != 1) return say_text(DicomRecord::kRefused, "pixels of several colours");
  using Pixels = gdcm::PixelFormat;
  static const std::map<Pixels::ScalarType, Element> kElements = {
      {Pixels::UINT8, Element::kUint8},   {Pixels::INT8, Element::kInt8},     {Pixels::UINT16, Element::kUint16},
      {Pixels::INT16, Element::kInt16},   {Pixels::UINT32, Element::kUint32}, {Pixels::INT32, Element::kInt32},
      {Pixels::FLOAT32, Element::kFloat}, {Pixels::FLOAT64, Element::kDouble}};
  const auto element = kElements.find(format.GetScalarType());
  if (element == kElements.end())
    return say_text(DicomRecord::kRefused, std::string("pixels of the type ") + format.GetScalarTypeAsString());
  head.element = static_cast<std::uint32_t>(element->second);
  head.inverted = image.GetPhotometricInterpretation() == gdcm::PhotometricInterpretation::MONOCHROME1;
  std::vector<char> bytes(image.GetBufferLength());
  if (bytes.empty() || !image.GetBuffer(bytes.data()))
    return say_text(DicomRecord::kRefused, "pixels that cannot be decoded");
  if (!remove_low_bits(reader.GetFile(), image, bytes))
    return say_text(DicomRecord::kRefused,
                    "Bits Stored (0028,0101) and High Bit (0028,0102) that contradict each other");
  const gdcm::Tag padding(0x0028, 0x0120), limit(0x0028, 0x0121);
  if (set.FindDataElement(padding)) {
    const bool is_signed = short_of(set, gdcm::Tag(0x0028, 0x0103)) == 1;
    const auto value = [&](const gdcm::Tag& tag) {
      const auto bits = static_cast<std::uint16_t>(short_of(set, tag));
      return is_signed ? static_cast<double>(static_cast<std::int16_t>(bits)) : static_cast<double>(bits);
    };
    const double first = value(padding), last = set.FindDataElement(limit) ? value(limit) : first;
    head.has_padding = 1, head.lowest_padding = std::min(first, last), head.highest_padding = std::max(first, last);
  }
  head.lossy = image.IsLossy();
  head.bytes = bytes.size();
  say(DicomRecord::kPixels, head);
  write_all(bytes.data(), bytes.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  const bool want_pixels = std::strcmp(argv[1], "pixels") == 0;
  std::vector<std::string> names;
  {
    std::ifstream list(argv[2], std::ios::binary);
    // Names are separated by zero bytes, because they may contain line ends.
    for (std::string name; std::getline(list, name, '\0');) names.push_back(name);
  }
  // Limits of this process: memory kBase + kCopies × image (bytes), processor time kSeconds.
  constexpr std::uint64_t kBase = 768ull << 20, kCopies = 5, kSeconds = 300;
  limit_process({.seconds = kSeconds,
                 .memory = kBase + kCopies * std::strtoull(argv[3], nullptr, 10),
                 .longest_file = std::strtoull(argv[4], nullptr, 10)});
  give_up_privileges();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  gdcm::Trace::DebugOff();
  for (std::uint32_t number = 0; number < names.size(); ++number) {
    // The name is empty if an earlier process that crashed has already handled this file.
    if (names[number].empty()) continue;
    say(DicomRecord::kBegins, number);
    try {
      if (want_pixels)
        pixels(names[number], number);
      else
        headers(names[number], number);
    } catch (const Malformed& malformed) {
      say_text(DicomRecord::kRefused, malformed.place + "\n" + malformed.found);
    } catch (const std::exception&) {
      if (want_pixels) {
        say_text(DicomRecord::kRefused, "pixels that cannot be decoded");
      } else {
        DicomFile file;
        file.number = number;
        file.kind = DicomKind::kUnreadable;
        say(DicomRecord::kFile, file);
      }
    }
  }
  const DicomRecord end = DicomRecord::kEnd;
  write_all(&end, sizeof end);
  std::_Exit(0);
}
