typodont_test(unit_implant KIND unit SOURCES unit/session_implant_test.cpp LIBS typodont_session)
typodont_test(property_implant KIND property SOURCES property/implant_end_test.cpp property/implant_law_test.cpp property/implant_model_test.cpp LIBS typodont_haptics)
typodont_test(property_implant_app KIND property SOURCES property/app_implant_test.cpp property/implant_plan_test.cpp LIBS typodont_app fmt::fmt
              TOGETHER ImplantPlanner)
