"""What ideal robots in imperfect skins would feel and show: data for benches and tests."""
