// What a session did, kind by kind. Each number is counted by the one thread that does the work and read when that has
// ended; nothing is counted that is not also done.
#pragma once

#include <array>
#include <cstdint>

namespace typodont {

struct WorkCounts {
  // Feeling and cutting.
  std::uint64_t ticks = 0, queries = 0;  // of the servo; looks into the field
  // Looks for tissue by the contact models that have it as spheres, triangles or vertices (haptics/work.h).
  std::uint64_t sphere_looks = 0, triangle_looks = 0, vertex_looks = 0;
  std::uint64_t patches = 0;     // cut out for the servo
  std::uint64_t voxels_cut = 0;  // gone through by cuts and fillings; none is ever re-distanced
  // Surface and picture.
  std::uint64_t bricks_meshed = 0, triangles_made = 0;
  std::uint64_t frames = 0, passes = 0, triangles_drawn = 0;
  std::uint64_t bricks_skipped = 0;    // culled, facing away or covered
  std::uint64_t pipelines = 0;         // shaders joined to pipelines, most alive at once
  std::uint64_t turns = 0;             // of the drawing thread, in most of which it draws nothing
  std::uint64_t desktop_requests = 0;  // what the desktop was asked or told
  std::uint64_t samples = 0;           // of sound
  std::uint64_t particles_stepped = 0;
  // The process.
  std::uint64_t allocations = 0, threads = 0, libraries = 0, bytes_written = 0;
  double cpu_seconds = 0, servo_cpu_seconds = 0;  // of all threads; of the one that serves the device
};

struct WorkCount {
  const char* name;  // as a JSON key
  const char* words;
  std::uint64_t value;
};
/// All but the times, in order.
std::array<WorkCount, 23> listed(const WorkCounts& counts);

/// What the process has done so far: bytes written, allocations, CPU time; threads and libraries it has now.
WorkCounts process_counts();

/// s since the command was given, as far as the system says: to 10 ms.
double seconds_since_command();

/// operator new of this program counts here; programs without it have none. One relaxed addition an allocation, and the
/// loops that must not wait make none.
void count_allocation() noexcept;

}  // namespace typodont
