// This file is included once in each namespace of lane_ops.h, that is, once for each vector width. It changes samples
// as a cut does (a cut raises the stored distances), and sums the removed volume of each tissue.

/// Raises samples: where `ahead` is set, a sample becomes `depth` (its depth in the head, which the caller has limited
/// to kInner, 3 voxels) if the depth exceeds both the old value and −kMargin (−3.5 voxels). Returns the new values.
/// `least` receives the limit that the depth had to exceed; `rises` receives the mask of the raised samples.
TYPODONT_INLINE Floats raised_to(Floats old, Floats depth, Mask ahead, Floats& least, Mask& rises) {
  least = greater(old, all(-Sweep::kMargin));
  rises = more_where(ahead, depth, least);
  return pick(rises, depth, old);
}

/// Returns the volume that each voxel loses when its distance rises from `was` to `is`, in integer units
/// (haptics/inside_fraction.h).
TYPODONT_INLINE Ints share_taken(Floats was, Floats is) {
  const Floats before = greater(was, all(-0.5f)), after = greater(lesser(is, all(0.5f)), before);
  return as_ints(after + all(1.5f)) - as_ints(before + all(1.5f));
}

/// Sums the removed volume of each tissue. As long as the label stays the same, it uses one running sum.
struct Taken {
  RemovedVolume* removed;
  GradedSamples graded;  // a copy of removed->graded, so that its pointers can stay in registers
  Ints units = {};
  // Sums of (removed volume in integer units × hardness byte). hard_low: sum of the low 16 bits of each product;
  // hard_high: sum of the other bits.
  Ints hard_low = {}, hard_high = {};
  int groups = 0;
  std::uint8_t label = 0;

  /// `to` receives the sums. It may be null, but then add() must not be called.
  TYPODONT_INLINE Taken(RemovedVolume* to) : removed(to) {
    if (to) graded = to->graded;
  }

  /// Adds the removed volume of a whole group of samples. All samples that lose volume have the label `group_label`.
  TYPODONT_INLINE void add(Ints taken, std::uint8_t group_label, const float* samples) {
    change_label(group_label);
    units += taken;
    if (graded.hardness && any_positive(taken)) {
      const std::ptrdiff_t at = samples - graded.distance;
      const Tissue* const labels = graded.tissue ? graded.tissue + at : nullptr;
      const Ints weighted = taken * felt_hardness(labels, graded.hardness + at);
      hard_low += low_half(weighted);
      hard_high += high_half(weighted);
    }
    if (++groups == 255) close();  // a sample loses at most 2^23 units, so the sum of 255 groups stays below 2^31
  }
  /// Adds the removed volume of the samples `from` .. `to` of a group of samples; their labels may differ. `labels`:
  /// label of the group's first sample.
  TYPODONT_INLINE void add(Ints taken, const Tissue* labels, const float* samples, int from, int to) {
    if (from == 0 && to == kLanes) {
      std::uint64_t parts[kLanes / 8], differ = 0;
      std::memcpy(parts, labels, sizeof parts);
      for (std::uint64_t& part : parts) part &= kShown * 0x0101010101010101u;
      for (const std::uint64_t part : parts) differ |= part ^ (parts[0] & 0xff) * 0x0101010101010101u;
      if (!differ) {
        add(taken, static_cast<std::uint8_t>(parts[0]), samples);
        return;
      }
    }
    std::int32_t apart[kLanes];
    std::memcpy(apart, &taken, sizeof apart);
    for (int i = from; i < to; ++i) removed->add(apart[i], shown(labels[i]), samples + i);
  }
  TYPODONT_INLINE void close() {
    removed->volume[label] += kFractionUnit * static_cast<double>(sum_of_lanes(units));
    if (graded.hardness) removed->hardened[label] += (sum_of_lanes(hard_high) << 16) + sum_of_lanes(hard_low);
    units = hard_low = hard_high = Ints{};
    groups = 0;
  }

 private:
  TYPODONT_INLINE void change_label(std::uint8_t group_label) {
    if (group_label == label) return;
    close();
    label = group_label;
  }
  TYPODONT_INLINE static std::int64_t sum_of_lanes(const Ints& v) {
    std::int32_t apart[kLanes];  // copy of the lanes of v, so that the sums can stay in a register
    std::memcpy(apart, &v, sizeof apart);
    std::int64_t sum = 0;
    for (const std::int32_t part : apart) sum += part;
    return sum;
  }
};
