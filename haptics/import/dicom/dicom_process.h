// Starts the guarded process that reads DICOM files, and reads its output.
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

/// Reads the headers of the files. If the reader process crashes on a file, this file counts as unreadable, and the
/// other files are still read.
std::vector<DicomHeader> read_dicom_headers(std::span<const std::filesystem::path> files);

/// Decodes the pixels of the files, one file after another, and passes them to `take`. `largest` is the size in bytes
/// of the pixels of the largest file, and `total` is that of all files; both come from the headers. Throws Error with
/// `name` if a file cannot be decoded.
void read_dicom_pixels(const std::string& name, std::span<const std::filesystem::path> files, std::uint64_t largest,
                       std::uint64_t total,
                       const std::function<void(const DicomPixels& pixels, std::vector<char>& bytes)>& take);

}  // namespace typodont::haptics::importing
