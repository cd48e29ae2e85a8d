typodont_test(property_implant KIND property SOURCES property/implant_law_test.cpp property/implant_model_test.cpp LIBS typodont_haptics)
typodont_test(acceptance_implant KIND acceptance SOURCES acceptance/app_implant_test.cpp LIBS typodont_app)
