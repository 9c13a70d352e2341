"""DuckDB queries over the Parquet parts of a sweep, without merging them, and over a table in memory.

    python duckdb_parts.py [--out by_base.csv] [--shards 4]
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import duckdb
import phalanx

STUDY = Path(__file__).resolve().parents[2] / "scenes" / "studies" / "thesis.toml"
BY_BASE = """
    select "design.base_m" as base_m,
           count(*) as runs,
           count(*) filter (class in ('stable', 'semi-stable')) as good,
           round(min(tts_s) * 1e3, 3) as soonest_ms,
           round(median(greatest(peak_f21_n, peak_f22_n)), 1) as median_peak_n
    from {source}
    group by base_m order by base_m
"""


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("by_base.csv"))
    parser.add_argument("--shards", type=int, default=4)
    parser.add_argument("--quick", action="store_true", help="accepted like in the other examples, but ignored, because this one is quick")
    args = parser.parse_args(arguments)

    with tempfile.TemporaryDirectory() as directory:
        # The same as `phalanx sweep --shard 1/4`, 2/4, … on several machines.
        parts = [Path(directory) / f"part-{k}.parquet" for k in range(1, args.shards + 1)]
        for k, part in enumerate(parts, start=1):
            phalanx.sweep_shard(STUDY, k, args.shards, part)
        by_base = duckdb.sql(BY_BASE.format(source=f"'{directory}/part-*.parquet'"))
        by_base.show()
        by_base.write_csv(str(args.out))
        # DuckDB reads a table in memory as an Arrow stream.
        table = phalanx.sweep(STUDY, limit=48)
        memory = duckdb.connect()
        memory.register("runs", table)
        [best] = memory.sql("select run, class, tts_s * 1e3 as tts_ms from runs order by tts_s nulls last limit 1").fetchall()
        print(f"{args.out}; shortest time to stability of the first {len(table)} runs: {best}")


if __name__ == "__main__":
    main()
