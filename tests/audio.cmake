typodont_test(unit_audio KIND unit
  SOURCES unit/audio_binaural_test.cpp unit/audio_fit_test.cpp unit/audio_filter_test.cpp unit/audio_synth_test.cpp unit/audio_output_test.cpp
          unit/audio_files_test.cpp
  LIBS typodont_audio)
typodont_test(property_audio KIND property SOURCES property/audio_test.cpp LIBS typodont_audio)
typodont_test(golden_audio KIND golden SOURCES golden/audio_test.cpp LIBS typodont_audio)
typodont_test(stress_audio KIND stress SOURCES stress/audio_test.cpp LIBS typodont_audio)
typodont_test(acceptance_audio KIND acceptance SOURCES acceptance/audio_sound_command_test.cpp LIBS typodont_audio typodont_render)
target_compile_definitions(acceptance_audio PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
add_dependencies(acceptance_audio typodont)
if(TYPODONT_PORTAUDIO)
  typodont_test(acceptance_audio_devices KIND acceptance SOURCES acceptance/audio_devices_test.cpp LIBS typodont_audio
                LIVE MEASURED SoundsAContactWithin)
  find_program(JACKD jackd)
  if(JACKD)
    target_compile_definitions(acceptance_audio_devices PRIVATE TYPODONT_JACKD="${JACKD}")
  endif()
endif()
