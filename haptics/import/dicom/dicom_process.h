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
  // first unreadable number: name of its attribute, newline, found text; empty: none
  std::string malformed;
};

/// Reads the headers. A file that crashes the reader counts as unreadable.
std::vector<DicomHeader> read_dicom_headers(std::span<const std::filesystem::path> files);

/// Reads the pixels of one file after another, and passes them to `take`. `largest`, `total`: bytes of the largest
/// image and of all images, as the headers state. `name`: name in the messages of Errors.
void read_dicom_pixels(const std::string& name, std::span<const std::filesystem::path> files, std::uint64_t largest,
                       std::uint64_t total,
                       const std::function<void(const DicomPixels& pixels, std::vector<char>& bytes)>& take);

}  // namespace typodont::haptics::importing
