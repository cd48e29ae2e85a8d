#!/usr/bin/env python3
"""Runs tests of the school's service: run.py PROGRAM MODULE…, with data in a temporary folder."""
import os
import pathlib
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "engine/school")]

if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="typodont_school_") as folder:
        os.environ.update(TYPODONT_SCHOOL_DATA=folder, TYPODONT_SCHOOL_PROGRAM=sys.argv[1], DJANGO_SETTINGS_MODULE="typodont_school.settings")
        import logging
        import django
        logging.disable(logging.CRITICAL)
        django.setup()
        from django.conf import settings
        from django.test.runner import DiscoverRunner
        settings.PASSWORD_HASHERS = ["django.contrib.auth.hashers.MD5PasswordHasher"]  # fast
        from django.db import connection
        if connection.vendor == "sqlite":
            connection.settings_dict["TEST"]["NAME"] = os.path.join(folder, "test.sqlite")  # a file: threads share it
        class Runner(DiscoverRunner):
            def suite_result(self, suite, result, **more):
                return len(result.failures) + len(result.errors) + (result.testsRun == 0)

        sys.exit(bool(Runner(verbosity=2).run_tests(sys.argv[2:])))
