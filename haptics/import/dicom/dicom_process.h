// Starts the guarded DICOM reader and reads its output.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "haptics/import/dicom/dicom_wire.h"

namespace typodont::haptics::importing {

struct DicomHeader {
  DicomFile file;
  std::vector<DicomFrame> frames;
  std::vector<std::string> references;  // names of the files to which a DICOMDIR refers
  std::string malformed;                // a number that cannot be read: "place\nfound"; empty: none
};

/// A file that crashes the reader counts as unreadable.
std::vector<DicomHeader> read_dicom_headers(std::span<const std::filesystem::path> files);

/// One file after another, passed to `take`. `largest`, `total`: bytes of pixels, from the headers. Throws Error with
/// `name`.
void read_dicom_pixels(const std::string& name, std::span<const std::filesystem::path> files, std::uint64_t largest,
                       std::uint64_t total,
                       const std::function<void(const DicomPixels& pixels, std::vector<char>& bytes)>& take);

}  // namespace typodont::haptics::importing
