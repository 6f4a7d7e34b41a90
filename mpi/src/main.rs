//! The command `zonal-mpi`: solves and animations shared by the processes of MPI.
//!
//! ```text
//! mpirun -n 4 zonal-mpi solve scene.toml -o run.npz
//! ```
//!
//! Every rank reads the scene; the first rank writes the solution and prints. Solutions have the bits of `zonal solve` on any number of ranks.

mod mpi_ranks;
mod placement;
mod stop;

use clap::{Parser, Subcommand};
use mpi::Threading;
use mpi::traits::Communicator as _;
use std::process::ExitCode;
use zonal_cli::commands::context::Context;
use zonal_cli::commands::{render, solve};
use zonal_report::{Failure, note};
use zonal_solve::distribution::{Communicator, CountedRanks, SentMessages};

/// Solve scenes, and draw animations, on several processes by MPI. Start it by mpirun or srun; solutions are those of the command `zonal`, to the bit, on any number of ranks.
#[derive(Parser, Debug)]
#[command(name = "zonal-mpi", version)]
struct Cli {
    /// Threads of each rank [default: its share of the processors of its machine].
    #[arg(long, global = true, value_name = "N")]
    threads: Option<u16>,
    /// Print the report as JSON.
    #[arg(long, global = true)]
    json: bool,
    /// No progress bars.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// End with exit code 1 if a warning was reported.
    #[arg(long, global = true)]
    strict: bool,
    /// Print what each rank sent, and how long it waited for messages.
    #[arg(long, global = true)]
    traffic: bool,
    /// Report wall time, processor time and threads at work of the first rank by phase.
    #[arg(long, global = true)]
    timings: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Solve a scene and write the solution (.npz).
    Solve(solve::Args),
    /// Draw the frames of an animation (--animate), each rank some of them.
    Render(Box<render::Args>),
}

/// Exit code where MPI cannot be used.
const MPI_FAILURE_CODE: u8 = 2;

fn main() -> ExitCode {
    let cli = Cli::try_parse();
    if let Ok(cli) = &cli {
        stop::report_stops(hint(&cli.command));
    }
    let Some((universe, _)) = mpi::initialize_with_threading(Threading::Funneled) else {
        eprintln!("error: MPI cannot be initialized; start the command by mpirun or srun");
        return ExitCode::from(MPI_FAILURE_CODE);
    };
    let world = universe.world();
    let is_first = world.rank() == 0;
    let cli = match cli {
        Ok(cli) => cli,
        Err(e) => {
            if is_first {
                // A closed output loses only the text.
                let _ = e.print();
            }
            return ExitCode::from(e.exit_code() as u8);
        }
    };
    let (ranks, server) = mpi_ranks::mpi_ranks(&world);
    let outcome = std::thread::scope(|scope| {
        let solve = scope.spawn(move || run(cli, &ranks));
        server.serve(&world);
        solve.join()
    });
    match outcome {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(e)) => {
            if is_first {
                eprintln!("error: {e}");
            }
            ExitCode::from(e.code())
        }
        // The panic has printed its message; the other ranks wait for this one.
        Err(_) => world.abort(i32::from(MPI_FAILURE_CODE)),
    }
}

fn run(cli: Cli, ranks: &mpi_ranks::MpiRanks) -> Result<(), Failure> {
    let quiet = cli.quiet || ranks.rank() > 0;
    zonal_cli::commands::start_threads(Some(placement::threads(ranks, cli.threads)))?;
    let timeline = cli.timings.then(Default::default);
    let context = Context { json: cli.json, quiet, strict: cli.strict, timeline: timeline.as_ref() };
    let counted = CountedRanks::new(ranks);
    match cli.command {
        Command::Solve(arguments) => solve::run_on_ranks(&arguments, context, &counted)?,
        Command::Render(arguments) => render::run_on_ranks(&arguments, context, &counted)?,
    }
    if ranks.rank() == 0 {
        context.say_timings()?;
    }
    if cli.traffic {
        report_traffic(ranks, counted.sent());
    }
    Ok(())
}

/// Prints bytes, calls and seconds of the messages of all ranks on the first one.
fn report_traffic(ranks: &mpi_ranks::MpiRanks, sent: SentMessages) {
    let own = format!(
        "{:.1} MB sent in {} calls, {:.2} s in messages",
        sent.bytes as f64 / 1e6,
        sent.calls,
        ranks.seconds_in_messages()
    );
    let all = ranks.all_gather(own.into_bytes());
    if ranks.rank() == 0 {
        for (rank, text) in all.iter().enumerate() {
            note(&format!("rank {rank}: {}", String::from_utf8_lossy(text)));
        }
    }
}

/// How a stopped solve goes on.
fn hint(command: &Command) -> String {
    let hint = match command {
        Command::Solve(arguments) if arguments.checkpoint.is_some() || arguments.resume => {
            "--resume continues from its checkpoint, on any number of ranks"
        }
        Command::Solve(_) => "with --checkpoint it could be resumed",
        Command::Render(_) => "the same command draws the frames that are missing",
    };
    hint.into()
}
